"""The progress line of a run."""

from __future__ import annotations

import sys
from typing import TextIO

from wbc.book import Progress

_SPARSE = 2.0  # s of the run between lines that are not rewritten


class ProgressLine:
    """On a terminal one line that is rewritten; elsewhere a line now and then.

    Args:
        stream: standard error when left out.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._rewrite = self._stream.isatty()
        self._next = 0.0
        self._open = False

    def show(self, progress: Progress) -> None:
        """Show how far the run is."""
        if not self._rewrite and progress.time < self._next:
            return
        self._next = progress.time + _SPARSE - 1e-6
        text = (
            f"{progress.time:5.1f} / {progress.duration:.1f} s   {progress.speed:.2f} m/s   "
            f"DCM error {1e3 * progress.dcm_error:4.1f} mm   tick {progress.tick_us:4.0f} µs"
        )
        self._stream.write(f"\r{text}\x1b[K" if self._rewrite else f"{text}\n")
        self._stream.flush()
        self._open = self._rewrite

    def note(self, text: str) -> None:
        """Say something on a line of its own."""
        self.close()
        self._stream.write(f"{text}\n")
        self._stream.flush()

    def close(self) -> None:
        """Leave the line as it is and go on below."""
        if self._open:
            self._stream.write("\n")
            self._open = False

"""The progress line of a run."""

from __future__ import annotations

import math
import sys
import time
from types import TracebackType
from typing import TextIO

from wbc.runtime.statistics import Progress

_BAR = 30  # letters
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
        whole = f" / {progress.duration:.1f}" if math.isfinite(progress.duration) else ""
        told = math.isfinite(progress.dcm_error)  # not by a controller without a DCM
        error = f"DCM error {1e3 * progress.dcm_error:4.1f} mm   " if told else ""
        text = (
            f"{progress.time:5.1f}{whole} s   {progress.speed:.2f} m/s   "
            f"{error}tick {progress.tick_us:4.0f} µs"
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


class Rendering:
    """A bar for the frames of a film, with the time that is left.

    Args:
        stream: standard error when left out.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._rewrite = self._stream.isatty()
        self._start = self._next = time.monotonic()

    def show(self, done: int, frames: int) -> None:
        """Show how many frames are done."""
        now = time.monotonic()
        if not self._rewrite and now < self._next and done < frames:
            return
        self._next = now + 10.0
        left = (now - self._start) / done * (frames - done)
        full = round(_BAR * done / frames)
        text = f"[{'█' * full}{'·' * (_BAR - full)}] frame {done} of {frames}, {left:.0f} s left"
        self._stream.write(f"\r{text}\x1b[K" if self._rewrite else f"{text}\n")
        self._stream.flush()

    def __enter__(self) -> Rendering:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._rewrite:
            self._stream.write("\n")

"""Progress on standard error."""

from __future__ import annotations

import math
import sys

from wbc.closeable import Closeable
from wbc.runtime.statistics import Progress


class ProgressLine(Closeable):
    """One line on standard error that is rewritten on a terminal, and repeated elsewhere.

    Args:
        period: time between two lines if they are not rewritten, s.
    """

    def __init__(self, period: float = 2.0) -> None:
        self._stream = sys.stderr
        self._rewrite = self._stream.isatty()
        self._period = period
        self._next = -math.inf
        self._open = False

    def show(self, text: str, time: float) -> None:
        """Show a text that describes the progress at a time, s."""
        before_reset = self._next - self._period > time  # the time of a new run begins at zero
        if self._rewrite or time >= self._next or before_reset:
            self._next = time + self._period - 1e-6
            self._stream.write(f"\r{text}\x1b[K" if self._rewrite else f"{text}\n")
            self._stream.flush()
            self._open = self._rewrite

    def print(self, text: str) -> None:
        """Print a message on a line of its own."""
        self.close()
        self._stream.write(f"{text}\n")

    def close(self) -> None:
        """Finish the line."""
        if self._open:
            self._stream.write("\n")
            self._open = False

    def show_run(self, progress: Progress) -> None:
        """Show the progress of a run."""
        whole = f" / {progress.duration:.1f}" if math.isfinite(progress.duration) else ""
        has_dcm = math.isfinite(progress.dcm_error)
        error = f"DCM error {1e3 * progress.dcm_error:4.1f} mm   " if has_dcm else ""
        self.show(
            f"{progress.time:5.1f}{whole} s   {progress.speed:.2f} m/s   "
            f"{error}tick {progress.tick_us:4.0f} µs",
            progress.time,
        )

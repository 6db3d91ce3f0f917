"""Progress on standard error, with the time left."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable

from wbc.closeable import Closeable
from wbc.runtime.statistics import Progress

_BAR_LENGTH = 30  # characters
_BAR_PERIOD = 10.0  # s between two lines of a bar if they are not rewritten
_BAR_DELAYS = (5.0, 0.5)  # s; what takes less needs no bar; elsewhere than on a terminal, on one
_MIN_ELAPSED = 1.0  # s, before which the time left cannot be told


class ProgressLine(Closeable):
    """One line on standard error that is rewritten on a terminal, and repeated elsewhere.

    Args:
        period: time between two lines if they are not rewritten, s.
        clock: returns a time, s.

    Attributes:
        rewrites: whether standard error is a terminal.
    """

    def __init__(self, period: float = 2.0, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream = sys.stderr
        self.rewrites = self._stream.isatty()
        self._period, self._clock = period, clock
        self._next = -math.inf
        self._open = False
        self._first: tuple[float, float] | None = None  # clock and time of a run when it was shown

    def show(self, text: str, time: float) -> None:
        """Show a text that describes the progress at a time, s."""
        before_reset = self._next - self._period > time  # the time of a new run begins at zero
        if self.rewrites or time >= self._next or before_reset:
            self._next = time + self._period - 1e-6
            self._stream.write(f"\r{text}\x1b[K" if self.rewrites else f"{text}\n")
            self._stream.flush()
            self._open = self.rewrites

    def print(self, text: str) -> None:
        """Print a message on a line of its own."""
        self.close()
        self._stream.write(f"{text}\n")

    def close(self) -> None:
        """Finish the line."""
        if self._open:
            self._stream.write("\n")
            self._open = False

    def clear(self) -> None:
        """Remove the line."""
        if self._open:
            self._stream.write("\r\x1b[K")
            self._open = False

    def show_run(self, progress: Progress) -> None:
        """Show the progress of a run."""
        whole = f" / {progress.duration:.1f}" if math.isfinite(progress.duration) else ""
        has_dcm = math.isfinite(progress.dcm_error)
        error = f"DCM error {1e3 * progress.dcm_error:4.1f} mm   " if has_dcm else ""
        self.show(
            f"{progress.time:5.1f}{whole} s   {progress.speed:.2f} m/s   "
            f"{error}tick {progress.tick_us:4.0f} µs{self._left(progress)}",
            progress.time,
        )

    def _left(self, progress: Progress) -> str:
        """Return the time left of a run, by the pace since it was first shown."""
        now = self._clock()
        if self._first is None or progress.time < self._first[1]:
            self._first = now, progress.time
        elapsed, done = now - self._first[0], progress.time - self._first[1]
        if elapsed < _MIN_ELAPSED or done <= 0.0 or not math.isfinite(progress.duration):
            return ""
        left = elapsed / done * max(progress.duration - progress.time, 0.0)
        return f"   {duration_text(left)} left"


class ProgressBar(Closeable):
    """A bar on standard error with the time left, if it takes longer than half a second.

    Args:
        what: what is done, e.g. "reading walk.mcap".
        clock: returns a time, s.
    """

    def __init__(self, what: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._what, self._clock = what, clock
        self._line = ProgressLine(_BAR_PERIOD)
        self._start = clock()

    def show(self, share: float) -> None:
        """Show what share is done, 0 to 1."""
        elapsed = self._clock() - self._start
        if elapsed < _BAR_DELAYS[self._line.rewrites] or share <= 0.0:
            return
        full = round(_BAR_LENGTH * share)
        bar = "█" * full + "·" * (_BAR_LENGTH - full)
        left = elapsed * (1.0 - share) / share
        self._line.show(f"[{bar}] {self._what}, {duration_text(left)} left", elapsed)

    def close(self) -> None:
        """Remove the bar."""
        self._line.clear()


def duration_text(seconds: float) -> str:
    """Return a duration in whole seconds, e.g. "40 s" or "2 min 05 s"."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02} s" if minutes else f"{rest} s"

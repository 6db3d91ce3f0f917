"""Progress of a run and of rendering, on standard error."""

from __future__ import annotations

import math
import sys
import time
from types import TracebackType
from typing import TextIO

from wbc.runtime.statistics import Progress

_BAR_LENGTH = 30  # characters
_LINE_PERIOD = 2.0  # s of the run between two lines if they are not rewritten
_RENDERING_PERIOD = 10.0  # s between two lines, likewise


class ProgressLine:
    """Shows the progress of a run: one line that is rewritten on a terminal, many lines elsewhere.

    Args:
        stream: output stream; standard error by default.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._rewrite = self._stream.isatty()
        self._next = 0.0
        self._open = False

    def show(self, progress: Progress) -> None:
        """Show the progress."""
        if not self._rewrite and progress.time < self._next:
            return
        self._next = progress.time + _LINE_PERIOD - 1e-6
        whole = f" / {progress.duration:.1f}" if math.isfinite(progress.duration) else ""
        has_dcm = math.isfinite(progress.dcm_error)
        error = f"DCM error {1e3 * progress.dcm_error:4.1f} mm   " if has_dcm else ""
        text = (
            f"{progress.time:5.1f}{whole} s   {progress.speed:.2f} m/s   "
            f"{error}tick {progress.tick_us:4.0f} µs"
        )
        self._stream.write(f"\r{text}\x1b[K" if self._rewrite else f"{text}\n")
        self._stream.flush()
        self._open = self._rewrite

    def print(self, text: str) -> None:
        """Print a message on a line of its own."""
        self.close()
        self._stream.write(f"{text}\n")
        self._stream.flush()

    def close(self) -> None:
        """Finish the line."""
        if self._open:
            self._stream.write("\n")
            self._open = False


class RenderingProgress:
    """Shows the progress of rendering a video: a bar and the remaining time.

    Args:
        stream: output stream; standard error by default.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._rewrite = self._stream.isatty()
        self._start = self._next = time.monotonic()

    def show(self, done: int, frames: int) -> None:
        """Show the progress.

        Args:
            done: number of rendered frames.
            frames: number of all frames.
        """
        now = time.monotonic()
        if not self._rewrite and now < self._next and done < frames:
            return
        self._next = now + _RENDERING_PERIOD
        left = (now - self._start) / done * (frames - done)
        full = round(_BAR_LENGTH * done / frames)
        bar = "█" * full + "·" * (_BAR_LENGTH - full)
        text = f"[{bar}] frame {done} of {frames}, {left:.0f} s left"
        self._stream.write(f"\r{text}\x1b[K" if self._rewrite else f"{text}\n")
        self._stream.flush()

    def __enter__(self) -> RenderingProgress:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._rewrite:
            self._stream.write("\n")

"""Rate and bandwidth at which messages arrive."""

from __future__ import annotations

from collections import deque

import numpy as np


class RateStatistics:
    """Statistics of the arrival times and sizes of the latest messages.

    Args:
        window: number of messages to evaluate.
    """

    def __init__(self, window: int = 1000) -> None:
        self._times: deque[float] = deque(maxlen=window + 1)
        self._sizes: deque[int] = deque(maxlen=window)

    def add(self, time: float, size: int = 0) -> None:
        """Add a message that arrived at a time, s, and has a size in bytes."""
        self._times.append(time)
        self._sizes.append(size)

    @property
    def hz(self) -> float:
        """Messages per second; 0 before the second message."""
        span = self._times[-1] - self._times[0] if len(self._times) > 1 else 0.0
        return (len(self._times) - 1) / span if span > 0.0 else 0.0

    def summary(self) -> str:
        """Return mean rate, jitter and bandwidth in one line."""
        if len(self._times) < 2:
            return "no new messages"
        gaps = np.diff(self._times)
        return (
            f"average rate: {self.hz:.3f} Hz   min: {gaps.min():.4f} s   max: {gaps.max():.4f} s   "
            f"std dev: {gaps.std():.5f} s   window: {len(gaps)}   "
            f"{self.hz * float(np.mean(self._sizes)) / 1e3:.1f} kB/s"
        )

"""How often messages come."""

from __future__ import annotations

from collections import deque

import numpy as np


class Rate:
    """Arrival times of the latest messages.

    Args:
        window: how many are looked at.
    """

    def __init__(self, window: int = 1000) -> None:
        self._times: deque[float] = deque(maxlen=window + 1)
        self._sizes: deque[int] = deque(maxlen=window)

    def note(self, time: float, size: int = 0) -> None:
        """A message came at some time, s, with so many bytes."""
        self._times.append(time)
        self._sizes.append(size)

    @property
    def hz(self) -> float:
        """Messages per second; 0 before there are two."""
        span = self._times[-1] - self._times[0] if len(self._times) > 1 else 0.0
        return (len(self._times) - 1) / span if span > 0.0 else 0.0

    def text(self) -> str:
        """Rate and regularity in one line."""
        if len(self._times) < 2:
            return "no new messages"
        gaps = np.diff(self._times)
        return (
            f"average rate: {self.hz:.3f} Hz   min: {gaps.min():.4f} s   max: {gaps.max():.4f} s   "
            f"std dev: {gaps.std():.5f} s   window: {len(gaps)}   "
            f"{self.hz * float(np.mean(self._sizes)) / 1e3:.1f} kB/s"
        )

"""Sensor readings that come late, or do not come for a while."""

from __future__ import annotations

from collections import deque

import numpy as np


class SensorDelay:
    """Delivers each reading some ticks after it was taken, and repeats one while frozen.

    Args:
        ticks: age of a reading when it is delivered, control periods.
    """

    def __init__(self, ticks: int) -> None:
        self._ticks = ticks
        self._readings: deque[np.ndarray] = deque(maxlen=ticks + 1)
        self._freezes: list[tuple[float, float]] = []
        self._delivered: np.ndarray | None = None

    def clear(self, reading: np.ndarray) -> None:
        """Start over: what is delivered at first is this reading."""
        self._freezes.clear()
        self._readings.clear()
        self._readings.append(reading.copy())
        self._delivered = None

    def add(self, reading: np.ndarray) -> None:
        """Take the reading of one tick."""
        self._readings.append(reading.copy())

    @property
    def oldest(self) -> np.ndarray:
        """The reading that is delivered now, before noise."""
        return self._readings[0]

    def freeze(self, begin: float, end: float) -> None:
        """Repeat the delivery before `begin` until `end`, s."""
        self._freezes.append((begin, end))

    def frozen(self, time: float) -> np.ndarray | None:
        """Return the delivery that is repeated at a time (s); None if a new one is due."""
        self._freezes = [freeze for freeze in self._freezes if time < freeze[1]]
        if any(begin <= time for begin, _ in self._freezes):
            return self._delivered
        return None

    def deliver(self, reading: np.ndarray) -> None:
        """Remember a delivery, noise included."""
        self._delivered = reading

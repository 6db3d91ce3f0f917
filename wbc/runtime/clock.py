"""A fixed-rate clock: it waits for the next period and records how late each one began."""

from __future__ import annotations

import time

import numpy as np

# How long before the next period the clock wakes up, to spin from there on: a little longer than
# the latest wake-ups were late, within these bounds, s.
_MIN_MARGIN, _MAX_MARGIN = 50e-6, 300e-6
_FACTOR = 1.25  # of the lateness of a wake-up
_DECAY = 0.999  # per period: a margin has halved after 700


class Clock:
    """Periods of the wall clock.

    Sleeps, then spins the last stretch, because the scheduler's wake-up alone is late by tens of
    microseconds at real-time priority, and by hundreds without.

    Args:
        dt: period, s.
        periods: expected number of periods, for which memory is allocated in advance.
    """

    def __init__(self, dt: float, periods: int) -> None:
        self._dt = dt
        self._late = np.zeros(max(periods, 1))
        self._count = 0
        self._margin = _MAX_MARGIN
        self._next = time.perf_counter()

    def wait(self) -> None:
        """Return at the beginning of the next period, or at once when it is overdue."""
        wake = self._next - self._margin
        left = wake - time.perf_counter()
        if left > 0.0:
            time.sleep(left)
            overslept = _FACTOR * (time.perf_counter() - wake)
            self._margin = max(_DECAY * self._margin, min(overslept, _MAX_MARGIN), _MIN_MARGIN)
        while (now := time.perf_counter()) < self._next:
            pass
        late = now - self._next
        self._late[self._count % self._late.size] = late
        self._count += 1
        # After a long hold-up, do not race to catch up.
        self._next = self._next + self._dt if late < 10.0 * self._dt else now + self._dt

    @property
    def lateness(self) -> np.ndarray:
        """The delay with which each period so far began, s, shape (periods,)."""
        return self._late[: self._count]

    @property
    def overruns(self) -> int:
        """Number of periods that began later than the next one was due."""
        return int((self.lateness > self._dt).sum())

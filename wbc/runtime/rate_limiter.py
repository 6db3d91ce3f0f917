"""Selecting time stamps at a given rate."""

from __future__ import annotations

_CLOCK_JUMP = 2.0  # periods by which a stamp lies before the expected one after a clock jump


class RateLimiter:
    """Selects from a stream of time stamps those at which something happens at a given rate.

    Args:
        rate: rate of the selected stamps, Hz.
        tolerance: a stamp that precedes its due time by less than this, s, is selected.
    """

    def __init__(self, rate: float, tolerance: float = 0.0) -> None:
        self._rate, self._tolerance = rate, tolerance
        self._next = float("-inf")

    def is_due(self, stamp: float) -> bool:
        """Return whether a stamp, s, is selected.

        Missed stamps are not made up for. A stamp that lies far before the expected one is taken
        for a jump of the clock and is selected.
        """
        period, left = 1.0 / self._rate, self._next - stamp
        if self._tolerance < left <= _CLOCK_JUMP * period:
            return False
        punctual = -period < left <= self._tolerance
        self._next = self._next + period if punctual else stamp + period
        return True

    def restart(self, rate: float) -> None:
        """Select the next stamp, and from there on at a new rate, Hz.

        Limiters that are restarted together with the same rate select the same stamps.
        """
        self._rate, self._next = rate, float("-inf")

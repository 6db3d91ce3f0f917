"""What happens at some rate, told by time stamps."""

from __future__ import annotations

_BACK = 2.0  # periods


class Due:
    """Says at which of many stamps something is due.

    Args:
        rate: Hz.
        early: a stamp that comes before its time by less than this, s, will do.
    """

    def __init__(self, rate: float, early: float = 0.0) -> None:
        self._rate, self._early = rate, early
        self._next = float("-inf")

    def __call__(self, stamp: float) -> bool:
        """Whether it is due at a stamp, s.

        What was missed is not made up for. A stamp far back is of another clock: it is due.
        """
        period, left = 1.0 / self._rate, self._next - stamp
        if self._early < left <= _BACK * period:
            return False
        punctual = -period < left <= self._early
        self._next = self._next + period if punctual else stamp + period
        return True

    def restart(self, rate: float) -> None:
        """It is due at the next stamp, and from there on at a rate, Hz.

        What is restarted at once with the same rate is due at the same stamps from then on.
        """
        self._rate, self._next = rate, float("-inf")

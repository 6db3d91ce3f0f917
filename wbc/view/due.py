"""The time of the next frame at a given rate."""

from __future__ import annotations


def next_due(due: float, now: float, period: float) -> float:
    """Return when the next frame is due, s.

    That is one period after this one was due, which keeps the mean rate whatever the rate of the
    caller; after a pause it is one period from now, so that frames are not made up for.

    Args:
        due: when this frame was due, s.
        now: when it was shown, s.
        period: between two frames, s.
    """
    return due + period if now - due < period else now + period

"""The time of the next frame at a given rate."""

from __future__ import annotations


def next_due(due: float, now: float, period: float) -> float:
    """Return when the next frame is due, s.

    The next frame is due one period after this one was due, which keeps the mean rate at any rate
    of calls; after a pause it is due one period from now, so that missed frames are skipped.

    Args:
        due: Time at which this frame was due, s.
        now: Time at which this frame was shown, s.
        period: Frame period, s.
    """
    return due + period if now - due < period else now + period

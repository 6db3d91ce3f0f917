"""When the next frame is due."""

from __future__ import annotations


def next_due(due: float, now: float, period: float) -> float:
    """The time of the frame after one that was due and has been shown now, s.

    Counted on from when it was due, so that the mean rate is kept whatever the
    loop's own rate; from now after a pause, so that nobody catches up.
    """
    return due + period if now - due < period else now + period

"""What the loop tells the page about its ticks, as numbers in shared memory."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from wbc.runtime.mode import Mode

NO_MOTION, RETURNING = -1, -2  # values of `playing`


@dataclass(frozen=True, slots=True)
class Gauges:
    """A tick as the page sees it, and the worst of those since the last; all of it numbers.

    Attributes:
        time: of the plant, s.
        mode: what the loop is doing.
        dcm_error: the largest, m.
        tick_time: that estimator and controller took at the most, s.
        forward: velocity that is wanted of the gait now, m/s.
        left: likewise, m/s.
        turn: likewise, rad/s.
        playing: index of the motion; -1 none, -2 on the way back to standing.
        pushes: that have been survived or not, so far.
        survived: how many of them.
        run: counts resets.
    """

    time: float
    mode: Mode
    dcm_error: float
    tick_time: float
    forward: float
    left: float
    turn: float
    playing: int
    pushes: int
    survived: int
    run: int

    @staticmethod
    def of(record: np.ndarray) -> Gauges:
        """The gauges in a record."""
        (time, mode, error, tick, forward, left, turn, playing, pushes, survived, run) = (
            record.tolist()
        )
        return Gauges(
            time,
            Mode(int(mode)),
            error,
            tick,
            forward,
            left,
            turn,
            int(playing),
            int(pushes),
            int(survived),
            int(run),
        )


SIZE = len(fields(Gauges))

"""One motion, one robot, one seed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from wbc.loop import RunComplete, run
from wbc.motions import Motion, Performer
from wbc.report import Report
from wbc.robot import Robot
from wbc.sim import Mujoco
from wbc.trials.judge import Judge

_LAST = 1.0  # s of standing after, in which it may still fall


class Curtain:
    """Ends a run when a performer has been standing idle for a second; a `before_tick`."""

    def __init__(self, performer: Performer) -> None:
        self._performer = performer
        self._since: float | None = None

    def __call__(self, time: float) -> None:
        """Look.

        Raises:
            RunComplete: everything is done.
        """
        if not self._performer.idle:
            self._since = None
        elif self._since is None:
            self._since = time
        elif time - self._since >= _LAST:
            raise RunComplete


def run_motions(
    robot: Robot,
    motions: Sequence[Motion],
    seed: int = 0,
    *,
    at_most: float = 120.0,
    before_tick: Callable[[float, Performer, Mujoco], None] | None = None,
) -> Report:
    """Play motions in MuJoCo with noisy sensors and the estimator; judged by the truth.

    Args:
        robot: the robot.
        motions: one after the other.
        seed: of the sensor noise.
        at_most: s.
        before_tick: called with time, performer and plant, e.g. to push.

    Raises:
        MotionError: the robot cannot do one of them.
    """
    performer = Performer(robot, motions=motions)
    judge, curtain = Judge(), Curtain(performer)
    with Mujoco(robot, dt=performer.dt, seed=seed) as plant:

        def tick(time: float) -> None:
            if before_tick is not None:
                before_tick(time, performer, plant)
            curtain(time)

        report = run(performer, plant, at_most, log=judge, before_tick=tick)
    return judge.amend(report)

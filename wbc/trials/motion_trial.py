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


class Stage:
    """What a performer needs around it in a simulation; called before each tick.

    Grants the pushes that a motion asks for, and ends the run when the performer has been
    standing idle for a second.

    Args:
        performer: the performer.
    """

    def __init__(self, performer: Performer) -> None:
        self._performer = performer
        self._since: float | None = None

    def __call__(self, time: float, plant: Mujoco) -> None:
        """Look after it.

        Raises:
            RunComplete: everything is done.
        """
        body = self._performer.body
        for impulse in body.pushes:
            turned = self._performer.walker.standing_frame.rotation @ impulse
            plant.push(body.robot.mass * turned)
        body.pushes.clear()
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
    judge, stage = Judge(), Stage(performer)
    with Mujoco(robot, dt=performer.dt, seed=seed) as plant:

        def tick(time: float) -> None:
            if before_tick is not None:
                before_tick(time, performer, plant)
            stage(time, plant)

        report = run(performer, plant, at_most, log=judge, before_tick=tick)
    return judge.amend(report)

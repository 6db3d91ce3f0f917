"""One motion, one robot, one seed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from wbc.motions import Motion, MotionPlayer
from wbc.robot import Robot
from wbc.runtime.loop import RunComplete, StopRun, run
from wbc.runtime.report import Report
from wbc.sim import Mujoco
from wbc.trials.evaluator import RunEvaluator

_LAST = 1.0  # s of standing after, in which it may still fall


class MotionRunner:
    """What a player needs around it in a simulation; called before each tick.

    Grants the pushes that a motion asks for, and ends the run when the player has been
    standing idle for a second.

    Args:
        player: the player.
        at_most: s until everything has to be done.
    """

    def __init__(self, player: MotionPlayer, at_most: float = math.inf) -> None:
        self._performer = player
        self._at_most = at_most
        self._since: float | None = None

    def __call__(self, time: float, plant: Mujoco) -> None:
        """Look after it.

        Raises:
            RunComplete: everything is done.
            StopRun: it should have been by now.
        """
        if time >= self._at_most:
            playing = self._performer.playing
            what = "it" if playing is None else f"'{playing.name}'"
            raise StopRun(f"{what} is not over after {self._at_most:g} s")
        for impulse in self._performer.pop_pushes():
            plant.push(impulse)
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
    at_most: float = 600.0,
    before_tick: Callable[[float, MotionPlayer, Mujoco], None] | None = None,
) -> Report:
    """Play motions in MuJoCo with noisy sensors and the estimator, and compare with the truth.

    Args:
        robot: the robot.
        motions: one after the other.
        seed: of the sensor noise.
        at_most: s; what is not over by then has not survived.
        before_tick: called with time, player and plant, e.g. to push.

    Raises:
        MotionError: the robot cannot do one of them.
    """
    player = MotionPlayer(robot, motions=motions)
    evaluator, runner = RunEvaluator(), MotionRunner(player, at_most)
    with Mujoco(robot, dt=player.dt, seed=seed) as plant:

        def tick(time: float) -> None:
            if before_tick is not None:
                before_tick(time, player, plant)
            runner(time, plant)

        report = run(player, plant, at_most + 1.0, log=evaluator, before_tick=tick)
    return evaluator.amend(report)

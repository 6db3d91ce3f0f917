"""Seeded trials of motions in physics."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from wbc.motions import Motion, MotionPlayer
from wbc.robot import Robot
from wbc.runtime.loop import RunComplete, StopRun, run
from wbc.runtime.report import Report
from wbc.sim import JointServos, Mujoco
from wbc.trials.evaluator import RunEvaluator

_STANDING = 1.0  # s of standing after the last motion, during which a fall still counts


class MotionRunner:
    """Applies pushes and payloads that motions request, and ends the run; called before each tick.

    The run ends when the player has been idle for one second.

    Args:
        player: the motion player.
        time_limit: time by which all motions must have ended, s.
    """

    def __init__(self, player: MotionPlayer, time_limit: float = math.inf) -> None:
        self._player = player
        self._time_limit = time_limit
        self._idle_since: float | None = None

    def __call__(self, time: float, plant: Mujoco) -> None:
        """Apply requested pushes and payloads before the tick at `time` (s).

        Raises:
            RunComplete: all motions have ended.
            StopRun: they have not ended within the time limit.
        """
        if time >= self._time_limit:
            playing = self._player.playing
            what = "the run" if playing is None else f"'{playing.name}'"
            raise StopRun(f"{what} has not ended after {self._time_limit:g} s")
        for impulse in self._player.pop_pushes():
            plant.push(impulse)
        for frame, mass in self._player.pop_payloads():
            plant.schedule_payload(plant.time, mass, frame)
        if not self._player.idle:
            self._idle_since = None
        elif self._idle_since is None:
            self._idle_since = time
        elif time - self._idle_since >= _STANDING:
            raise RunComplete


def run_motions(
    robot: Robot,
    motions: Sequence[Motion],
    seed: int = 0,
    *,
    time_limit: float = 600.0,
    before_tick: Callable[[float, MotionPlayer, Mujoco], None] | None = None,
    servos: JointServos | None = None,
    latency: float = 0.0,
) -> Report:
    """Play motions in MuJoCo with noisy sensors and the estimator, and compare with the true state.

    Args:
        robot: the robot.
        motions: played one after the other.
        seed: seed of the sensor noise.
        time_limit: time by which all motions must have ended, s; later counts as not survived.
        before_tick: called with time (s), player and plant before each tick, e.g. to push.
        servos: what the joints are driven by; none: ideal sources of torque.
        latency: from the measurement to its effect, s.

    Raises:
        MotionError: the robot cannot perform one of the motions.
    """
    player = MotionPlayer(robot, motions=motions)
    evaluator, runner = RunEvaluator(), MotionRunner(player, time_limit)
    with Mujoco(robot, dt=player.dt, seed=seed, servos=servos, latency=latency) as plant:

        def tick(time: float) -> None:
            if before_tick is not None:
                before_tick(time, player, plant)
            runner(time, plant)

        report = run(player, plant, time_limit + 1.0, observers=[evaluator], before_tick=tick)
    return evaluator.amend(report)

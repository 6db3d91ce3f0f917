"""Pushes that the soles cannot catch: quick steps, then the normal gait or standing again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import wbc
from wbc.gait import Phase
from wbc.runtime.fall import fall_reason
from wbc.sim import Mujoco

pytest.importorskip("mujoco")

DIRECTIONS = {
    "forward": (1.0, 0.0, 0.0),
    "back": (-1.0, 0.0, 0.0),
    "left": (0.0, 1.0, 0.0),
    "right": (0.0, -1.0, 0.0),
}


class ClosedLoop:
    """Plant with noisy sensors, estimator and walker of a robot that stands."""

    def __init__(self, name: str, **walker: object) -> None:
        self.robot = wbc.load(name)
        self.plant = Mujoco(self.robot, seed=3)
        self.estimator = wbc.Estimator(self.robot)
        self.walker = wbc.Walker(self.robot, **walker)
        start = self.plant.ground_truth()
        self.estimator.reset(start)
        self.walker.reset(start)
        self._acceleration: np.ndarray | None = None
        self.recovering_ticks = 0

    def push(self, direction: str, size: float) -> None:
        """Push the torso for 0.1 s; size in N·s per kg of the robot."""
        self.plant.push(size * self.robot.mass * np.array(DIRECTIONS[direction]))

    def run(self, seconds: float) -> str:
        """Run for a time; return why the robot fell, or an empty text."""
        for _ in range(round(seconds / self.plant.dt)):
            estimate = self.estimator.update(self.plant.measure(), acceleration=self._acceleration)
            command = self.walker.step(estimate)
            self._acceleration = command.acceleration
            self.plant.step(command)
            state = self.walker.gait_state
            self.recovering_ticks += state.recovering or state.shortened
            fall = fall_reason(self.robot, self.plant.ground_truth())
            if fall:
                return fall
        return ""


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("name", ["g1", "talos"])
def test_a_standing_robot_steps_when_pushed_and_stands_again_with_its_feet_side_by_side(
    name, direction
):
    loop = ClosedLoop(name)
    loop.run(0.3)
    loop.push(direction, 0.4)
    assert loop.run(3.5) == ""
    walker = loop.walker
    assert walker.steps > 0
    assert walker.gait_state.phase is Phase.STAND
    assert not walker.gait_state.recovering
    between = walker.feet.left.to_local(walker.feet.right.point)
    assert abs(between - complex(0.0, -walker.gait.step_width)) < 0.03


@pytest.mark.parametrize("direction", ["left", "right", "forward"])
def test_a_walking_robot_is_quick_after_a_push_and_returns_to_its_normal_gait(direction):
    loop = ClosedLoop("g1")
    loop.walker.velocity = (0.2, 0.0, 0.0)
    loop.run(2.0)
    steps = loop.walker.steps
    loop.push(direction, 0.3)
    assert loop.run(2.5) == ""
    assert loop.recovering_ticks > 0
    usual = 2.5 / loop.walker.gait.step_duration
    assert loop.walker.steps - steps > usual
    loop.recovering_ticks = 0
    assert loop.run(1.0) == ""
    assert loop.recovering_ticks == 0


def test_the_same_push_fells_a_walker_without_a_recovery_gait():
    gait = wbc.Walker(wbc.load("g1")).gait
    loop = ClosedLoop("g1", gait=gait, recovery_gait=gait)
    loop.walker.velocity = (0.2, 0.0, 0.0)
    loop.run(2.0)
    loop.push("left", 0.3)
    assert loop.run(2.5) != ""
    assert loop.recovering_ticks == 0


@pytest.mark.parametrize(("name", "speed"), [("g1", 0.39), ("talos", 0.5)])
def test_an_undisturbed_walk_never_leaves_the_normal_gait(name, speed):
    loop = ClosedLoop(name)
    loop.walker.velocity = (speed, 0.0, 0.0)
    assert loop.run(4.0) == ""
    loop.walker.velocity = (0.0, 0.0, 0.0)
    assert loop.run(2.0) == ""
    assert loop.recovering_ticks == 0


def test_recovery_steps_are_quicker_narrower_and_wider_than_the_normal_ones():
    walker = wbc.Walker(wbc.load("g1"))
    normal, quick = walker.gait, walker.recovery_gait
    assert quick.step_duration < 0.5 * normal.step_duration
    assert quick.least_width < normal.least_width
    assert quick.max_side_step > normal.max_side_step


def test_another_gait_changes_the_recovery_gait_with_it():
    walker = wbc.Walker(wbc.load("g1"))
    walker.change_gait(replace(walker.gait, swing_height=0.08))
    assert walker.recovery_gait.swing_height == 0.08
    assert walker.gait_state.recovery_gait is walker.recovery_gait

"""Walking on unseen slopes: the soles tell the slope, and the swing foot lands on it."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.gait import Phase, Placement, SwingFoot
from wbc.gait.leg_workspace import LegWorkspace
from wbc.sim import Mujoco, Ramp
from wbc.walking.ground_slope import GroundSlope
from wbc.walking.height_reference import HeightReference


# Without the estimate of the slope talos gets 1.13 m far and g1 1.45 m.
@pytest.mark.parametrize(("name", "angle", "distance"), [("talos", 10.0, 1.3), ("g1", 8.0, 1.52)])
def test_robot_walks_up_an_unseen_ramp(name, angle, distance):
    robot = wbc.load(name)
    walker = wbc.Walker(robot)
    slopes: list[complex] = []

    def before_tick(time: float) -> None:
        walker.velocity = (0.3 if 0.3 < time < 6.2 else 0.0, 0.0, 0.0)
        slopes.append(walker.gait_state.ground_slope)

    ramp = Ramp(math.radians(angle), length=4.0, distance=0.25)
    with Mujoco(robot, terrain=ramp, seed=2) as plant:
        report = wbc.run(walker, plant, 7.5, before_tick=before_tick)
        travelled = plant.ground_truth().q[:3] - robot.standing().q[:3]
    assert report.survived
    assert travelled[0] > distance
    climbed = (travelled[0] - 0.25) * math.tan(math.radians(angle))
    assert travelled[2] == pytest.approx(climbed, abs=0.06)
    assert slopes[-1].real == pytest.approx(math.tan(math.radians(angle)), abs=0.05)
    assert abs(slopes[-1].imag) < 0.05


def walk_over(slopes: list[complex]) -> list[complex]:
    """Estimated slope after each of some single supports, in which the sole has a slope."""
    state = wbc.Walker(wbc.load("simple_humanoid")).gait_state
    estimate, estimates = GroundSlope(0.002), []
    for k, slope in enumerate(slopes):
        state.support = ("left", "right")[k % 2]
        soles = (slope, 9.0 + 9.0j) if state.support == "left" else (9.0 + 9.0j, slope)
        state.phase = Phase.SWING
        for tick in range(250):
            state.time = 0.002 * tick
            estimate.update(state, soles)
        state.phase = Phase.TRANSFER
        estimates.append(estimate.update(state, soles))
    return estimates


def test_level_ground_with_stones_has_no_slope():
    stones = [0j, 0.08 + 0.1j, 0j, -0.1 + 0.02j, 0.07 - 0.05j, 0.1 + 0.04j, -0.03 + 0.06j]
    assert walk_over(stones) == [0j] * len(stones)


def test_slope_is_known_after_the_third_sole_on_it_and_level_ground_after_the_first():
    slope = 0.17 - 0.1j
    estimates = walk_over([0j, 0j, slope, slope, slope, slope, 0j])
    assert estimates[:4] == [0j] * 4
    assert estimates[4:6] == pytest.approx([0.15 - 0.08j] * 2, abs=1e-3)
    assert estimates[6] == 0j


@pytest.mark.parametrize(("progress", "sinks"), [(0.9, False), (1.1, True)])
def test_the_com_sinks_with_a_foot_that_is_late_because_the_ground_is_lower(progress, sinks):
    state = wbc.Walker(wbc.load("simple_humanoid")).gait_state
    state.phase, state.duration, state.time = Phase.SWING, 0.5, 0.5 * progress
    state.landing = state.other_foot
    state.swing = SwingFoot(state.other_foot, state.landing, state.duration, 0.06, 0.05)
    state.swing.motion.position[2] = state.landing.height - 0.04
    height = HeightReference(LegWorkspace(wbc.load("simple_humanoid")), 0.1, 0.002)
    height.reset(state.stance.height, state.gait.com_height)
    for _ in range(500):
        height.update(state, 0.0)
    lower = 0.035 if sinks else 0.0
    assert height.ground == pytest.approx(state.stance.height - lower, abs=1e-3)


@pytest.mark.parametrize("slope", [0.15 + 0j, -0.1 + 0.12j])
@pytest.mark.parametrize("yaw", [0.0, 1.1])
def test_swing_sole_turns_from_the_slope_it_leaves_to_that_where_it_lands(slope, yaw):
    swing = SwingFoot(Placement(0j, yaw), Placement(0.2 + 0j, yaw, 0.03), 0.6, 0.06, 0.05, -0.05j)
    dt, before = 0.002, swing.motion.rotation.copy()
    np.testing.assert_allclose(before[:, 2] / before[2, 2], [0.0, 0.05, 1.0], atol=1e-12)
    for _ in range(300):
        swing.advance(dt, swing.target, slope)
        now = swing.motion.rotation.copy()
        np.testing.assert_allclose(now @ now.T, np.eye(3), atol=1e-12)
        rate = pin.log3(now @ before.T) / dt
        np.testing.assert_allclose(swing.motion.velocity[3:5], rate[:2], atol=0.06)
        before = now
    np.testing.assert_allclose(
        before[:, 2] / before[2, 2], [-slope.real, -slope.imag, 1.0], atol=1e-9
    )
    assert math.atan2(before[1, 0], before[0, 0]) == pytest.approx(yaw, abs=1e-9)

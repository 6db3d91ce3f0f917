"""The set of velocities of a gait, and the joint angles that it is found from."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.gait import Velocity, VelocityLimits, check_walking
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.parameters import can_turn
from wbc.gait.step_motion import StepMotion
from wbc.geometry.planar import Placement
from wbc.sim import Mujoco
from wbc.walking import WaypointFollower

LIMITS = VelocityLimits(forward=0.5, backward=0.3, left=0.1, turn=0.4)
numbers = st.floats(-3.0, 3.0)


@given(numbers, numbers, numbers)
def test_clamped_velocity_is_within_the_limits_in_the_same_direction(forward, left, turn):
    wanted = np.array([forward, left, turn])
    got = np.array(LIMITS.clamp(forward, left, turn))
    assert LIMITS.usage(*got) <= 1.0 + 1e-9
    assert np.cross(wanted, got) == pytest.approx(np.zeros(3), abs=1e-9)
    assert wanted @ got >= 0.0
    if LIMITS.usage(forward, left, turn) <= 1.0:
        assert got == pytest.approx(wanted)


def test_one_direction_at_a_time_reaches_its_limit():
    assert LIMITS.clamp(9.0, 0.0, 0.0) == pytest.approx((0.5, 0.0, 0.0))
    assert LIMITS.clamp(-9.0, 0.0, 0.0) == pytest.approx((-0.3, 0.0, 0.0))
    assert LIMITS.clamp(0.0, 9.0, 0.0) == pytest.approx((0.0, 0.1, 0.0))
    assert VelocityLimits().clamp(9.0, -9.0, 9.0) == (9.0, -9.0, 9.0)


def test_a_direction_that_is_excluded_is_left_out_of_a_velocity():
    limits = VelocityLimits(forward=0.5, backward=0.3, left=0.1, turn=0.0)
    assert limits.clamp(0.4, 0.0, 2.0) == pytest.approx((0.4, 0.0, 0.0))
    assert limits.usage(0.4, 0.0, 0.1) == math.inf
    assert limits.usage(0.5, 0.0, 0.0) == pytest.approx(1.0)


def test_a_robot_on_points_cannot_turn() -> None:
    robot = wbc.load("bolt")
    walker = wbc.Walker(robot)
    assert walker.gait.max_velocity.turn == 0.0
    assert "cannot-turn" in [finding.code for finding in check_walking(robot)]
    with pytest.warns(wbc.VelocityClamped, match="±0.00, one at a time"):
        walker.velocity = (0.1, 0.0, 0.5)
    assert walker.velocity == pytest.approx((0.1, 0.0, 0.0))


def test_legs_without_a_joint_about_the_vertical_cannot_turn() -> None:
    welded = wbc.load("talos", fixed_joints=["leg_*_1_joint"])
    assert not can_turn(welded)
    assert can_turn(wbc.load("talos"))


def test_a_robot_that_cannot_turn_steps_sideways_to_a_far_place() -> None:
    follower = WaypointFollower(LIMITS, near=0.8)
    place, pose = Placement(3j, 0.0), Placement(0j, 0.0)
    assert follower.velocity(place, pose)[2] > 0.0
    limits = VelocityLimits(forward=0.5, backward=0.3, left=0.1, turn=0.0)
    forward, left, turn = WaypointFollower(limits, near=0.8).velocity(place, pose)
    assert (forward, turn) == (0.0, 0.0)
    assert left == pytest.approx(0.1)


def test_leg_angles_put_the_soles_where_the_gait_has_them():
    robot = wbc.load("talos")
    gait = wbc.GaitParameters.for_robot(robot)
    motion = StepMotion(robot, LegWorkspace(robot))
    (left, right) = motion.angles(gait, Velocity())
    legs = len(robot.legs[0])
    assert np.abs(right[:, 0] - left[:, legs]).max() < 1e-6  # hip yaw: the feet do not turn
    # One leg does in its swing what the other does in its own, mirrored in yaw and roll.
    mirror = np.array([-1.0, -1.0, 1.0, 1.0, 1.0, -1.0])
    assert left[:, :legs] == pytest.approx(right[:, legs:] * mirror, abs=0.01)


@pytest.mark.parametrize(("name", "direction"), [("romeo", "turn"), ("icub", "left")])
def test_joint_ranges_and_speeds_limit_the_velocity(name: str, direction: str) -> None:
    robot = wbc.load(name)
    workspace = LegWorkspace(robot)
    gait = wbc.GaitParameters.for_robot(robot)
    limit = getattr(gait.velocity_limits, direction)
    reach = {"turn": gait.max_turn, "left": gait.max_side_step}[direction]
    assert limit < 0.5 * reach / (2.0 * gait.step_duration)
    motion = StepMotion(robot, workspace)
    allowed = np.maximum(motion.excess(gait, Velocity()), 0.0)
    assert np.all(motion.excess(gait, Velocity(**{direction: limit})) <= allowed)
    assert np.any(motion.excess(gait, Velocity(**{direction: 1.2 * limit})) > allowed)


def test_reversals_at_the_limits_do_not_fell_the_robot() -> None:
    robot = wbc.load("romeo")
    walker = wbc.Walker(robot)
    limits = walker.gait.max_velocity
    directions = ((0.6, 0.6, 0.5), (-0.6, -0.5, 0.6), (0.0, 0.7, -0.7), (0.8, -0.6, 0.0))

    def command(time: float) -> None:
        shares = directions[min(int(time / 1.8), len(directions) - 1)]
        wanted = limits.clamp(*(2.0 * s * v for s, v in zip(shares, limits.largest, strict=True)))
        assert limits.usage(*wanted) == pytest.approx(1.0)
        if walker.velocity != wanted:
            walker.velocity = wanted

    with Mujoco(robot, seed=0) as plant:
        report = wbc.run(walker, plant, 1.8 * len(directions), before_tick=command)
    assert report.survived, report.table()
    assert report.dcm_error_rms_mm is not None
    assert report.dcm_error_rms_mm < 15.0
    assert math.isfinite(limits.turn)

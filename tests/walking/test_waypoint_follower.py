"""The waypoint follower: from the way that is left to a velocity command."""

from __future__ import annotations

import cmath
import math
import warnings

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import wbc
from wbc.gait import Phase, VelocityLimits
from wbc.geometry.planar import Placement, ground_point, yaw_of
from wbc.walking import VelocityClamped, WaypointFollower

LIMITS = VelocityLimits(0.3, 0.3, 0.1, 0.4)


def test_the_command_points_to_the_waypoint_in_the_robots_heading_frame():
    pose = Placement(1 + 2j, 0.5 * math.pi)
    goal = Placement(1 + 4j, 0.5 * math.pi + 0.4)  # 2 m ahead of a robot that faces +y
    velocity = WaypointFollower(gains=(1.5, 1.5, 2.0)).velocity(goal, pose)
    assert velocity == pytest.approx((3.0, 0.0, 0.8))


def test_a_command_beyond_the_limits_keeps_its_direction():
    follower = WaypointFollower(limits=LIMITS)
    forward, left, turn = follower.velocity(Placement(1 + 1j, 0.5), Placement(0j, 0.0))
    assert forward == pytest.approx(left)
    assert turn == pytest.approx(0.5 * left)
    assert LIMITS.usage(forward, left, turn) == pytest.approx(1.0)


def test_sway_around_a_reached_place_starts_no_step():
    follower, goal = WaypointFollower(), Placement(0j, 0.0)
    assert follower.velocity(goal, Placement(0.15j, 0.1)) != (0.0, 0.0, 0.0)
    assert follower.velocity(goal, Placement(0.09j, 0.04)) == (0.0, 0.0, 0.0)
    assert follower.velocity(goal, Placement(0.15j, 0.1)) == (0.0, 0.0, 0.0)
    assert follower.position_reached
    assert follower.velocity(goal, Placement(0.21j, 0.0))[1] < 0.0


def test_a_robot_that_obeys_comes_to_the_place_from_everywhere():
    for bearing in range(8):
        follower = WaypointFollower(limits=LIMITS)
        goal = Placement(cmath.rect(1.0, 0.25 * math.pi * bearing), math.pi)
        pose = Placement(0j, 0.0)
        for _ in range(3000):
            forward, left, turn = follower.velocity(goal, pose)
            pose = pose.compose(Placement(0.01 * complex(forward, left), 0.01 * turn))
        assert abs(goal.point - pose.point) <= 0.1
        assert abs(goal.relative_to(pose).yaw) <= 0.05


def test_a_turn_about_keeps_its_direction():
    follower = WaypointFollower(limits=LIMITS)
    here = Placement(0j, 0.0)
    assert follower.velocity(Placement(0j, math.pi - 0.01), here)[2] > 0.0
    assert follower.velocity(Placement(0j, math.pi + 0.1), here)[2] > 0.0
    assert follower.velocity(Placement(0j, -1.0), here)[2] < 0.0


def test_a_command_at_the_limits_is_taken_without_a_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error", VelocityClamped)
        walker = wbc.Walker(wbc.load("g1"))
        follower = WaypointFollower.for_gait(walker.gait)
        place = walker.stopping_place
        walker.velocity = follower.velocity(place.compose(Placement(1 + 1j, 1.0)), place)
    assert min(walker.velocity) > 0.0


HERE = Placement(0j, 0.0)
coordinates = st.floats(-3.0, 3.0)
poses = st.builds(
    Placement, st.builds(complex, coordinates, coordinates), st.floats(-math.pi, math.pi)
)


def follower():
    """Return a follower that turns to far waypoints."""
    return WaypointFollower(
        LIMITS, (0.6, 0.6, 0.6), near=0.8, reached=(0.05, 0.07), left=(0.1, 0.15)
    )


@given(poses)
def test_velocity_stays_within_the_limits(error):
    assert LIMITS.usage(*follower().velocity(error, HERE)) <= 1.0 + 1e-9


def test_robot_turns_before_walking_to_a_far_goal_behind_it():
    forward, left, turn = follower().velocity(Placement(complex(-2.0, 0.1), 0.0), HERE)
    assert (forward, left) == (0.0, 0.0)
    assert turn > 0.0


def test_robot_steps_back_to_a_near_goal_behind_it():
    forward, _, turn = follower().velocity(Placement(complex(-0.3, 0.0), 0.0), HERE)
    assert forward < 0.0
    assert turn == 0.0


@given(poses)
@settings(max_examples=50)
def test_robot_arrives_although_velocities_take_effect_a_step_later(goal):
    """The delay is 0.8 s, the longest one of a gait."""
    robot, dt, delay = Placement(0j, 0.0), 0.05, 16
    controller = follower()
    pending = [(0.0, 0.0, 0.0)] * delay
    for _ in range(int(120.0 / dt)):
        pending.append(controller.velocity(goal, robot))
        if controller.position_reached and controller.yaw_reached:
            return
        forward, left, turn = pending.pop(0)
        robot = robot.compose(Placement(complex(forward, left) * dt, turn * dt))
    pytest.fail(f"the remaining error is {goal.relative_to(robot)}")


def test_the_time_left_is_that_of_a_robot_that_obeys():
    limits = VelocityLimits(0.3, 0.2, 0.1, 0.3)
    ahead = WaypointFollower(limits, reached=(0.05, 0.07)).time_left(Placement(3.0 + 0j, 0.0), HERE)
    assert 10.0 <= ahead < 13.0
    behind = follower().time_left(Placement(-2.0 + 0j, 0.0), HERE)
    assert behind > 0.8 * math.pi / 0.4 + 1.5 / 0.3
    assert follower().time_left(HERE, HERE) == 0.0


def test_a_robot_comes_to_rest_at_the_place_by_its_own_estimate():
    pytest.importorskip("mujoco")
    robot = wbc.load("simple_humanoid")
    walker = wbc.Walker(robot)
    follower = WaypointFollower.for_gait(walker.gait)
    goal = walker.stopping_place.compose(Placement(0.2 - 0.04j, -0.3))

    def follow(_: float) -> None:
        walker.velocity = follower.velocity(goal, walker.stopping_place)

    with wbc.sim.Mujoco(robot, seed=1) as plant:
        report = wbc.run(walker, plant, 6.0, before_tick=follow)
        truth = plant.ground_truth()
    assert report.survived
    assert walker.gait_state.phase is Phase.STAND
    kin = wbc.Kinematics(robot, truth)
    left, right = (kin.frame(sole.name) for sole in robot.soles)
    middle = 0.5 * (ground_point(left.translation) + ground_point(right.translation))
    assert abs(middle - goal.point) < 0.03
    assert abs(yaw_of(left.rotation) - goal.yaw) < 0.05

"""Feedback from a pose error to a walking velocity, without a robot."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wbc.gait import VelocityLimits
from wbc.geometry.planar import Placement
from wbc.ros.bridge.pose_controller import PoseController

MAX_VELOCITY = VelocityLimits(0.3, 0.2, 0.1, 0.3)
CONTROLLER = PoseController(MAX_VELOCITY, near=0.8, gain=0.6)
coordinates = st.floats(-3.0, 3.0)
poses = st.builds(
    Placement, st.builds(complex, coordinates, coordinates), st.floats(-math.pi, math.pi)
)


@given(poses, poses)
def test_relative_to_and_compose_are_inverse(goal, robot):
    back = robot.compose(goal.relative_to(robot))
    assert abs(back.point - goal.point) < 1e-9
    assert math.cos(back.yaw - goal.yaw) == pytest.approx(1.0)


@given(poses)
def test_velocity_stays_within_the_limits(error):
    assert MAX_VELOCITY.usage(*CONTROLLER.velocity(error)) <= 1.0 + 1e-9


def test_robot_turns_before_walking_to_a_far_goal_behind_it():
    forward, left, turn = CONTROLLER.velocity(Placement(complex(-2.0, 0.1), 0.0))
    assert (forward, left) == (0.0, 0.0)
    assert turn > 0.0


def test_robot_steps_back_to_a_near_goal_behind_it():
    forward, _, turn = CONTROLLER.velocity(Placement(complex(-0.3, 0.0), 0.0))
    assert forward < 0.0
    assert turn == 0.0


@given(poses)
@settings(max_examples=50)
def test_robot_arrives_although_velocities_take_effect_a_step_later(goal):
    """The delay is 0.8 s, the longest one of a gait."""
    robot, dt, delay = Placement(0j, 0.0), 0.05, 16
    pending = [(0.0, 0.0, 0.0)] * delay
    for _ in range(int(120.0 / dt)):
        error = goal.relative_to(robot)
        if abs(error.point) < 0.05 and abs(error.yaw) < 0.07:
            return
        pending.append(CONTROLLER.velocity(error))
        forward, left, turn = pending.pop(0)
        robot = robot.compose(Placement(complex(forward, left) * dt, turn * dt))
    pytest.fail(f"the remaining error is {goal.relative_to(robot)}")

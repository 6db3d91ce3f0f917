"""Trajectories of joints, without a robot."""

from __future__ import annotations

import numpy as np
import pytest

from wbc.messages import message_type
from wbc.ros.bridge.joint_trajectory import JointTrajectory
from wbc.ros.stamp import duration_from_seconds
from wbc.teleop import CommandRefused

Point = message_type("trajectory_msgs/msg/JointTrajectoryPoint")
Trajectory = message_type("trajectory_msgs/msg/JointTrajectory")


def message(*points, joints=("elbow",)):
    """Return a message of points (time, positions, velocities)."""
    made = [
        Point(positions=p, velocities=v, time_from_start=duration_from_seconds(t))
        for t, p, v in points
    ]
    return Trajectory(joint_names=list(joints), points=made)


def test_points_without_velocities_are_joined_by_lines():
    found = JointTrajectory.parse(message((0.0, [0.0], []), (2.0, [1.0], []), (3.0, [1.0], [])))
    assert [found.at(t)[0] for t in (-1.0, 0.0, 0.5, 2.5, 9.0)] == [0.0, 0.0, 0.25, 1.0, 1.0]


def test_points_with_velocities_are_joined_by_cubics_that_have_them():
    found = JointTrajectory.parse(message((1.0, [0.0], [0.5]), (2.0, [1.0], [-0.5])))
    step = 1e-6
    for time, position, velocity in ((1.0, 0.0, 0.5), (2.0 - step, 1.0, -0.5)):
        slope = (found.at(time + step) - found.at(time)) / step
        assert found.at(time)[0] == pytest.approx(position, abs=1e-5)
        assert slope[0] == pytest.approx(velocity, abs=1e-4)


def test_trajectory_that_is_too_fast_names_joint_velocity_and_limit():
    found = JointTrajectory.parse(message((0.0, [0.0], [0.0]), (1.0, [1.0], [0.0])))
    found.check_velocity(np.array([1.5]))  # a cubic from rest to rest peaks at 1.5 times the mean
    with pytest.raises(CommandRefused, match=r"'elbow' would move at 1.50 rad/s .* 1.40 rad/s"):
        found.check_velocity(np.array([1.4]))


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (message(), "no points"),
        (message((1.0, [0.0], []), (1.0, [0.0], [])), "do not increase"),
        (message((0.0, [0.0, 1.0], [])), "1 joints have 2 positions"),
        (message((0.0, [0.0], [0.0]), (1.0, [0.0], [])), "1 joints have 0 velocities"),
        (message((0.0, [float("nan")], [])), "positions is not finite"),
    ],
)
def test_invalid_trajectory_is_refused_with_the_reason(bad, reason):
    with pytest.raises(CommandRefused, match=reason):
        JointTrajectory.parse(bad)

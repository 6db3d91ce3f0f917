"""The waypoint follower: from the way that is left to a velocity command."""

from __future__ import annotations

import cmath
import math

import pytest

from wbc.geometry.planar import Placement
from wbc.walking import WaypointFollower


def test_the_command_points_to_the_waypoint_in_the_robots_heading_frame():
    pose = Placement(1 + 2j, 0.5 * math.pi)
    goal = Placement(1 + 4j, 0.5 * math.pi + 0.4)  # 2 m ahead of a robot that faces +y
    velocity = WaypointFollower(position_gain=1.5, yaw_gain=2.0).velocity(goal, pose)
    assert velocity == pytest.approx((3.0, 0.0, 0.8))


def test_a_command_beyond_the_limits_keeps_its_direction():
    follower = WaypointFollower(limits=(0.3, 0.1, 0.4))
    forward, left, turn = follower.velocity(Placement(1 + 1j, 0.5), Placement(0j, 0.0))
    assert (forward, left) == pytest.approx((0.1, 0.1))
    assert turn == pytest.approx(0.05)


def test_sway_around_a_reached_place_starts_no_step():
    follower, goal = WaypointFollower(), Placement(0j, 0.0)
    assert follower.velocity(goal, Placement(0.15j, 0.1)) != (0.0, 0.0, 0.0)
    assert follower.velocity(goal, Placement(0.09j, 0.04)) == (0.0, 0.0, 0.0)
    assert follower.velocity(goal, Placement(0.15j, 0.1)) == (0.0, 0.0, 0.0)
    assert follower.position_reached
    assert follower.velocity(goal, Placement(0.21j, 0.0))[1] < 0.0


def test_a_robot_that_obeys_comes_to_the_place_from_everywhere():
    for bearing in range(8):
        follower = WaypointFollower(limits=(0.3, 0.1, 0.4))
        goal = Placement(cmath.rect(1.0, 0.25 * math.pi * bearing), math.pi)
        pose = Placement(0j, 0.0)
        for _ in range(3000):
            forward, left, turn = follower.velocity(goal, pose)
            pose = pose.compose(Placement(0.01 * complex(forward, left), 0.01 * turn))
        assert abs(goal.point - pose.point) <= 0.1
        assert abs(goal.relative_to(pose).yaw) <= 0.05

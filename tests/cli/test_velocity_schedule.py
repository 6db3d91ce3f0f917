"""When the command line commands which velocity."""

import pytest

import wbc
from wbc.cli import velocity_schedule


@pytest.mark.parametrize("duration", [0.5, 3.0, 10.0, 60.0])
def test_a_walk_is_framed_by_standing(duration):
    walk = velocity_schedule.walk((0.3, 0.0, 0.1), duration)
    assert walk.velocity(0.0) == (0.0, 0.0, 0.0)
    assert walk.velocity(0.4 * duration) == (0.3, 0.0, 0.1)
    assert walk.velocity(0.99 * duration) == (0.0, 0.0, 0.0)


def test_a_long_walk_leaves_three_seconds_to_stop():
    walk = velocity_schedule.walk((0.3, 0.0, 0.0), 10.0)
    assert walk.velocity(6.9) == (0.3, 0.0, 0.0)
    assert walk.velocity(7.1) == (0.0, 0.0, 0.0)


def test_a_tour_goes_every_way_within_what_the_robot_can_do():
    limits = wbc.GaitParameters.for_robot(wbc.load("simple_humanoid")).max_velocity
    tour = velocity_schedule.tour(limits)
    seen = [tour.velocity(0.1 * k) for k in range(int(10 * velocity_schedule.TOUR_DURATION))]
    for axis, limit in enumerate(limits):
        assert any(velocity[axis] != 0.0 for velocity in seen)
        assert all(abs(velocity[axis]) <= limit for velocity in seen)
    assert any(velocity[0] < 0.0 for velocity in seen), "it never walks backward"
    assert seen[0] == seen[-1] == (0.0, 0.0, 0.0)

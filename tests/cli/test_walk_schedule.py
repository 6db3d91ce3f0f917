"""When the command line commands which velocity."""

import pytest

import wbc
from wbc.cli.walk import TOUR_DURATION, tour_schedule, walk_schedule


def velocity(schedule, time):
    return next((v for start, v in reversed(schedule) if time >= start), (0.0, 0.0, 0.0))


@pytest.mark.parametrize("duration", [0.5, 3.0, 10.0, 60.0])
def test_a_walk_is_framed_by_standing(duration):
    walk = walk_schedule((0.3, 0.0, 0.1), duration)
    assert velocity(walk, 0.0) == (0.0, 0.0, 0.0)
    assert velocity(walk, 0.4 * duration) == (0.3, 0.0, 0.1)
    assert velocity(walk, 0.99 * duration) == (0.0, 0.0, 0.0)


def test_a_long_walk_leaves_three_seconds_to_stop():
    walk = walk_schedule((0.3, 0.0, 0.0), 10.0)
    assert velocity(walk, 6.9) == (0.3, 0.0, 0.0)
    assert velocity(walk, 7.1) == (0.0, 0.0, 0.0)


def test_a_tour_goes_every_way_within_what_the_robot_can_do():
    limits = wbc.GaitParameters.for_robot(wbc.load("simple_humanoid")).max_velocity
    tour = tour_schedule(limits)
    seen = [velocity(tour, 0.1 * k) for k in range(int(10 * TOUR_DURATION))]
    assert all(any(v[axis] != 0.0 for v in seen) for axis in range(3))
    assert all(limits.usage(*v) <= 1.0 for v in seen)
    assert any(v[0] < 0.0 for v in seen), "it never walks backward"
    assert seen[0] == seen[-1] == (0.0, 0.0, 0.0)

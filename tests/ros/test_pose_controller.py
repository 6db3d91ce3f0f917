"""Walking to a pose: where from, where to, and how the way is walked, without a robot."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wbc.ros.bridge.pose_controller import PlanarPose, PoseController

FAST = (0.3, 0.1, 0.3)
WAY = PoseController(FAST, near=0.8, gain=0.6)
poses = st.builds(
    PlanarPose, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-math.pi, math.pi)
)


@given(poses, poses)
def test_relative_to_and_in_world_of_undo_each_other(goal, here):
    back = goal.relative_to(here).in_world_of(here)
    assert math.dist((back.x, back.y), (goal.x, goal.y)) < 1e-9
    assert math.cos(back.heading - goal.heading) == pytest.approx(1.0)


@given(poses)
def test_all_directions_together_take_no_more_than_one_may(error):
    shares = [abs(v) / most for v, most in zip(WAY.velocity(error), FAST, strict=True)]
    assert sum(shares) <= 1.0 + 1e-9


def test_it_turns_before_it_walks_to_what_is_far_behind():
    forward, left, turn = WAY.velocity(PlanarPose(-2.0, 0.1, 0.0))
    assert (forward, left) == (0.0, 0.0)
    assert turn > 0.0


def test_it_steps_back_to_what_is_near_behind():
    forward, _, turn = WAY.velocity(PlanarPose(-0.3, 0.0, 0.0))
    assert forward < 0.0
    assert turn == 0.0


@given(poses)
@settings(max_examples=50)
def test_a_walker_that_obeys_with_a_delay_of_a_step_arrives(goal):
    """The velocity of 0.8 s ago: as slow as a gait takes one up."""
    here, dt, delay = PlanarPose(0.0, 0.0, 0.0), 0.05, 16
    pending = [(0.0, 0.0, 0.0)] * delay
    for _ in range(int(120.0 / dt)):
        error = goal.relative_to(here)
        if error.distance < 0.05 and abs(error.heading) < 0.07:
            return
        pending.append(WAY.velocity(error))
        forward, left, turn = pending.pop(0)
        here = PlanarPose(forward * dt, left * dt, turn * dt).in_world_of(here)
    pytest.fail(f"it is still {goal.relative_to(here)} away")

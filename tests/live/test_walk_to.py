"""A place on the floor as a command of the live page: what is refused, and why."""

from __future__ import annotations

import pytest
from coretools import robot

import wbc
from wbc.gait import VelocityLimits
from wbc.live.walk_to import WalkTo
from wbc.teleop import CommandRefused


def test_a_heading_that_the_robot_cannot_turn_to_is_refused_with_the_bound_and_the_cure() -> None:
    cannot_turn = VelocityLimits(forward=0.5, backward=0.3, left=0.1, turn=0.0)
    walk_to = WalkTo(robot("bolt"), cannot_turn)
    with pytest.raises(CommandRefused, match=r"at most 0 rad/s.*leave the heading out"):
        walk_to.start([1.0, 0.0, 1.57])
    assert walk_to.target is None
    walk_to.start([1.0, 0.0, None])
    assert walk_to.target == (1.0, 0.0, None)


def test_a_robot_that_turns_accepts_a_heading() -> None:
    walk_to = WalkTo(robot("talos"), wbc.GaitParameters.for_robot(robot("talos")).max_velocity)
    walk_to.start([1.0, 0.0, 1.57])
    assert walk_to.target == (1.0, 0.0, 1.57)

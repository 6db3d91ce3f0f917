"""Cross-over steps: on which side the swing foot passes the support foot, and where it lands."""

from __future__ import annotations

from dataclasses import replace

import pytest

import wbc
from wbc.gait import GaitState, Phase, Placement, SwingFoot
from wbc.robot import Robot
from wbc.walking.stabilizer.cross_over import CrossOver

BEHIND = -0.22  # m: farther than a sole of G1 is long


@pytest.fixture(scope="module")
def g1() -> Robot:
    return wbc.load("g1")


def swinging(robot: Robot, along: float, across: float) -> GaitState:
    """The state of a quick swing with the left foot ahead of the right one and to its left.

    Args:
        robot: the robot.
        along: m.
        across: m.
    """
    state = wbc.Walker(robot).gait_state
    state.phase, state.support, state.shortened = Phase.SWING, "right", True
    state.gait = state.recovery_gait
    foot = state.stance.to_world(complex(along, across))
    state.feet = replace(state.feet, left=state.feet.left._replace(point=foot))
    return state


def landing(robot: Robot, state: GaitState, along: float, across: float) -> complex:
    """Where the foot lands if it is wanted there, in the support sole's axes, m."""
    stance = state.stance
    wanted = Placement(stance.to_world(complex(along, across)), stance.yaw, stance.height)
    return stance.to_local(CrossOver(robot).nearest(state, wanted).point)


def test_a_foot_passes_the_support_foot_on_the_side_where_it_is(g1):
    cross_over, wanted = CrossOver(g1), complex(0.0, -0.2)
    assert cross_over.side(swinging(g1, BEHIND, 0.24), wanted, 0.0) == -1.0
    assert cross_over.side(swinging(g1, -BEHIND, 0.24), wanted, 0.0) == 1.0
    assert cross_over.side(swinging(g1, 0.1, 0.24), wanted, 0.0) == 0.0


def test_a_foot_crosses_over_only_for_a_landing_place_beyond_the_support_foot(g1):
    state, cross_over = swinging(g1, BEHIND, 0.24), CrossOver(g1)
    assert cross_over.side(state, complex(0.0, 0.0), 0.0) == 0.0
    assert cross_over.side(state, complex(0.4, -0.2), 0.0) == 0.0  # that is far ahead


def test_a_robot_that_walks_ahead_fast_does_not_cross_over_behind(g1):
    state, cross_over = swinging(g1, BEHIND, 0.24), CrossOver(g1)
    wanted = complex(0.12, -0.2)
    assert cross_over.side(state, wanted, 0.0) == -1.0
    assert cross_over.side(state, wanted, 0.2) == 0.0
    assert cross_over.side(state, wanted, -0.2) == -1.0


def test_a_foot_that_cannot_stop_before_the_support_foot_does_not_cross_over(g1):
    state, cross_over = swinging(g1, BEHIND, 0.24), CrossOver(g1)
    start = state.feet.left
    state.swing = SwingFoot(start, start, 0.2, 0.05, 0.05)
    wanted = complex(0.0, -0.2)
    assert cross_over.side(state, wanted, 0.0) == -1.0
    state.swing.motion.velocity[0] = 3.5  # stops after 0.17 m
    assert cross_over.side(state, wanted, 0.0) == 0.0
    state.swing.motion.velocity[0] = -3.5
    assert cross_over.side(state, wanted, 0.0) == -1.0


def test_a_foot_that_a_blow_has_thrown_past_the_support_foot_lands_there(g1):
    cross_over, wanted = CrossOver(g1), complex(0.0, -0.2)
    for along, side in ((BEHIND, -1.0), (-BEHIND, 1.0), (0.1, 0.0)):  # or the legs touch
        state = swinging(g1, along, -0.3)
        start = state.feet.left
        state.swing = SwingFoot(start, start, 0.2, 0.05, 0.05)
        assert cross_over.side(state, wanted, 0.0) == 0.0  # it came there by itself, and goes back
        state.swing.knocked = True
        assert cross_over.side(state, wanted, 0.0) == side
        assert cross_over.side(state, complex(0.0, 0.2), 0.0) == 0.0  # it is wanted elsewhere


def test_a_foot_goes_on_crossing_over_only_while_it_has_to_or_is_about_to(g1):
    cross_over = CrossOver(g1)
    beside, between = swinging(g1, BEHIND, 0.24), swinging(g1, BEHIND, 0.05)
    across, ahead = complex(0.0, -0.2), complex(0.3, 0.2)
    assert cross_over.goes_on(beside, across)
    assert not cross_over.goes_on(beside, ahead)
    assert cross_over.goes_on(between, ahead)


def test_a_foot_far_behind_that_is_a_little_too_near_swings_ahead(g1):
    least = wbc.Walker(g1).gait_state.recovery_gait.least_width
    behind = swinging(g1, 2.0 * BEHIND, 0.8 * least)
    assert landing(g1, behind, 0.3, 0.2).real == pytest.approx(0.3)
    crossed = swinging(g1, BEHIND, -0.5 * least)
    assert landing(g1, crossed, 0.3, 0.2).real == pytest.approx(BEHIND, abs=0.03)


def test_a_foot_does_not_cross_over_far_off_for_a_little_way_across(g1):
    state, cross_over = swinging(g1, BEHIND, 0.24), CrossOver(g1)
    assert cross_over.side(state, complex(0.12, -0.2), 0.0) == -1.0
    assert cross_over.side(state, complex(0.12, -0.034), 0.0) == 0.0
    assert cross_over.side(state, complex(-0.2, -0.034), 0.0) == -1.0


def test_a_foot_that_moves_towards_the_support_foot_lands_farther_off(g1):
    state = swinging(g1, BEHIND, 0.24)
    state.crossing, state.duration = -1.0, 0.2
    state.swing = SwingFoot(state.feet.left, state.feet.left, 0.2, 0.05, 0.05)
    at_rest = landing(g1, state, 0.0, -0.3).real
    state.swing.motion.velocity[0] = 1.5
    assert landing(g1, state, 0.0, -0.3).real < at_rest - 0.03


def test_a_cross_over_step_lands_beyond_the_support_foot_and_a_sole_behind_it(g1):
    state = swinging(g1, BEHIND, 0.24)
    assert landing(g1, state, 0.0, -0.3).imag == pytest.approx(state.recovery_gait.least_width)
    state.crossing = -1.0
    place = landing(g1, state, 0.0, -0.3)
    assert -0.15 < place.imag < -0.05
    soles = sum(sole.half_length for sole in g1.soles)
    assert -0.3 < place.real < -soles


def test_a_foot_that_comes_back_passes_on_the_same_side_and_lands_anywhere_afterwards(g1):
    soles = sum(sole.half_length for sole in g1.soles)
    crossed = landing(g1, swinging(g1, -BEHIND, -0.1), 0.0, 0.4)
    assert crossed.real > soles
    assert crossed.imag == pytest.approx(0.4)
    assert landing(g1, swinging(g1, -BEHIND, 0.1), 0.0, 0.4).real == pytest.approx(0.0, abs=1e-9)

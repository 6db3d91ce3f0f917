"""Whatever a motion's script asks for, the robot keeps its balance, and the motion says why not."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from cases import slow
from hypothesis import given, settings
from hypothesis import strategies as st

import wbc
from wbc.errors import MotionError
from wbc.motions import Motion, MotionPlayer
from wbc.motions.engine.com_reference import ComReference

pytest.importorskip("mujoco")

OMEGA = 3.3
SQUARE = [complex(x, y) for x, y in ((0.1, 0.1), (-0.1, 0.1), (-0.1, -0.1), (0.1, -0.1))]


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


def scripted(script):
    """A motion of this script."""

    class Scripted(Motion):
        name = "scripted"
        summary = "for a test"

        def play(self, context):
            yield from script(context)

    return Scripted()


def play(robot, script, duration):
    player = MotionPlayer(robot, motions=[scripted(script)])
    with wbc.sim.Mujoco(robot, seed=3) as plant:
        report = wbc.run(player, plant, duration)
    return player, report


def from_half_a_second_on(value):
    return lambda t: np.zeros(3) if t < 0.5 else value()


def com_path(value):
    def script(context):
        context.com.follow(from_half_a_second_on(value))
        yield from context.wait(3.0)

    return script


def hand_path(value):
    def script(context):
        context.hands.follow(
            "left", lambda t: np.array([0.3, 0.3, 1.0]) + from_half_a_second_on(value)(t)
        )
        yield from context.wait(3.0)

    return script


def key_error(context):
    yield from context.wait(0.3)
    _ = {}["nobody"]


def shaken(context):
    context.com.follow(lambda t: np.array([0.03 * np.sin(18.0 * t), 0.0, 0.0]))
    yield from context.wait(3.0)


def com_to(*place):
    def script(context):
        yield from context.wait(0.2)
        context.com.move_to(place, 0.1)
        yield from context.wait(3.0)

    return script


def bend(context):
    yield from context.wait(0.2)
    context.turn_trunk([0.0, 1.5, 0.0])
    yield from context.wait(3.0)


def far_off(context):
    yield from context.wait(0.2)
    context.posture.move_to(1e6)
    yield from context.wait(3.0)


FAULTS = {
    "a path that is not a number": (com_path(lambda: np.full(3, np.nan)), "finite numbers"),
    "a path of another size": (com_path(lambda: np.zeros(4)), "needs 3 finite numbers"),
    "a path that raises": (com_path(lambda: 1 / 0), "ZeroDivisionError"),
    "a path that jumps away": (com_path(lambda: np.array([1.0, 0.0, 0.0])), "DCM goes"),
    "a hand's path that is not a number": (hand_path(lambda: np.full(3, np.inf)), "finite"),
    "a script that raises": (key_error, "KeyError: 'nobody'"),
    "shaking beyond the feet": (shaken, "of what the soles support"),
    "a CoM in front of the toes": (com_to(0.2, 0.0, 0.0), "of what the soles support"),
    "a CoM beside the feet": (com_to(0.0, -0.3, 0.0), "of what the soles support"),
    "a CoM near the ground": (com_to(0.0, 0.0, -0.5), "counts as a fall"),
    "a trunk bent too far": (bend, "counts as a fall"),
    "a posture out of this world": (far_off, "more than 30 s"),
}


@pytest.mark.parametrize(("script", "why"), FAULTS.values(), ids=FAULTS)
def test_a_motion_with_an_error_is_aborted_and_the_robot_stands(robot, script, why, caplog):
    with caplog.at_level(logging.CRITICAL, "wbc.motions.engine.player"):
        player, report = play(robot, script, 3.5)
    assert player.aborted_motions == ("scripted",)
    assert why in player.context.notes[-1]
    assert report.survived, report.fell_why
    assert report.qp_failures == 0
    assert player.idle
    assert player.context.at_home


def test_an_error_of_a_script_is_logged_with_its_traceback(robot, caplog):
    player = MotionPlayer(robot, motions=[scripted(key_error)])
    estimate = wbc.Estimate(robot.standing())
    for _ in range(200):
        player.step(estimate)
    (record,) = caplog.records
    assert "the motion 'scripted' raised an error" in record.getMessage()
    assert record.exc_info[0] is KeyError


@pytest.mark.parametrize("place", [(0.07, 0.0, 0.0), (-0.05, 0.05, -0.05), (0.0, 0.1, 0.0)])
def test_fast_com_move_within_the_support_takes_the_time_it_needs(robot, place):
    player, report = play(robot, com_to(*place), 4.0)
    assert player.aborted_motions == ()
    assert report.survived, report.fell_why


@pytest.mark.slow
def test_foot_held_far_out_returns_before_it_is_put_down(robot):
    def script(context):
        yield from context.feet.lift("left", 0.15)
        yield from context.feet.move_foot(forward=0.1, left=0.2, up=0.2)
        raise MotionError("enough")

    player, report = play(robot, script, 10.0)
    assert player.aborted_motions == ("scripted",)
    assert report.survived, report.fell_why
    assert report.qp_failures == 0
    assert player.idle
    feet = player.walker.feet
    stance = wbc.Walker(robot).feet
    apart, before = (abs(f.left.point - f.right.point) for f in (feet, stance))
    assert apart == pytest.approx(before, abs=0.02)


def at_random(seed):
    """A script of orders that nobody in their senses would give."""

    def script(context):
        rng = np.random.default_rng(seed)
        leg = context.robot.leg_length
        for _ in range(5):
            time = rng.uniform(0.1, 1.0)
            order = rng.integers(7)
            if order == 0:
                context.com.move_to(rng.uniform([-0.1, -0.15, -0.2], [0.1, 0.15, 0.05]), time)
            elif order == 1:
                size, rate = rng.uniform(0.0, 0.05, 3), rng.uniform(1.0, 12.0)
                context.com.follow(lambda t, size=size, rate=rate: size * np.sin(rate * t))
            elif order == 2:
                context.turn_trunk(rng.uniform(-1.0, 1.0, 3) * [0.6, 0.9, 1.2], time)
            elif order == 3:
                for side in context.hands.sides:
                    place = rng.uniform([-0.5, -1.0, 0.2], [1.0, 1.0, 2.0])
                    context.hands.reach(side, place, time)
            elif order == 4 and context.standing:
                yield from context.feet.lift(
                    ("left", "right")[rng.integers(2)], rng.uniform(0.03, 0.35) * leg
                )
            elif order == 5 and context.stance.lifted:
                yield from context.feet.move_foot(*(rng.uniform(-0.2, 0.3, 3) * leg), time)
            elif order == 6 and context.stance.may_walk:
                context.feet.walk(rng.uniform(-1.0, 1.0, 3) * [0.3, 0.1, 0.2])
            yield from context.wait(rng.uniform(0.1, 0.6))

    return script


@pytest.mark.parametrize("seed", [0, slow(1), slow(2)])
def test_random_commands_make_no_robot_fall(robot, seed):
    _, report = play(robot, at_random(seed), 6.0)
    assert report.survived, report.fell_why
    assert report.qp_failures == 0


def reference(support=lambda: SQUARE):
    return ComReference(
        speed=1.0, acceleration=1.0, omega=OMEGA, descent=lambda: 0.3, support=support
    )


@given(x=st.floats(-0.085, 0.085), y=st.floats(-0.085, 0.085), duration=st.floats(0.0, 3.0))
@settings(max_examples=50)
def test_accepted_com_path_keeps_the_zmp_within_the_soles(x, y, duration):
    com = reference()
    com.move_to([x, y, 0.0], duration)
    while not com.arrived:
        com.advance(0.002)
        zmp = com.value - com.acceleration / OMEGA**2
        assert np.abs(zmp[:2]).max() <= 0.1 + 1e-3


@given(angle=st.floats(0.0, 6.3), distance=st.floats(0.13, 10.0))
def test_com_target_outside_the_support_is_refused_without_motion(angle, distance):
    com = reference()
    with pytest.raises(MotionError, match="soles support"):
        com.move_to([distance * np.cos(angle), distance * np.sin(angle), 0.0], 5.0)
    com.advance(0.002)
    assert com.at_home


@given(speed=st.floats(0.02, 0.07))
@settings(max_examples=30)
def test_com_path_is_refused_while_the_robot_can_still_return(speed):
    com, ticks = reference(), 0

    def advance():
        nonlocal ticks
        while ticks < 10_000:
            com.advance(0.002)
            ticks += 1

    com.follow(lambda t: np.array([speed * t, 0.0, 0.0]))
    with pytest.raises(MotionError, match="DCM goes"):
        advance()
    # 0.4 s before the path's DCM is 12 mm from the edge, some ticks more or less.
    end = 0.088 / speed - 1.0 / OMEGA
    assert 0.002 * ticks == pytest.approx(end - 0.4, abs=0.03)


def test_while_stepping_the_com_reference_moves_up_and_down_only():
    com = reference(support=list)
    com.move_to([0.0, 0.0, -0.05], 1.0)
    with pytest.raises(MotionError, match="while the robot steps"):
        com.move_to([0.05, 0.0, 0.0], 1.0)
    assert com.goal.tolist() == [0.0, 0.0, -0.05]


def test_a_path_with_a_large_vertical_acceleration_is_refused():
    com = reference()
    with pytest.raises(MotionError, match="accelerates by"):
        com.follow(lambda t: np.array([0.0, 0.0, 0.05 * np.sin(15.0 * t)]))

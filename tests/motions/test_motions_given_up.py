"""Motions during a push: what does not combine with the steps that catch it is given up."""

from __future__ import annotations

import numpy as np
import pytest
from cases import slow
from coretools import robot

import wbc
from wbc.gait import Phase
from wbc.motions import Motion, MotionPlayer
from wbc.motions.bow import Bow
from wbc.motions.one_leg import OneLeg
from wbc.motions.squat import Squat
from wbc.motions.wave import Wave
from wbc.runtime.loop import RunComplete
from wbc.sim import Mujoco

pytest.importorskip("mujoco")

_CAUGHT = 1.5  # s after a push: a robot that falls has fallen

DIRECTIONS = {
    "forward": np.array([1.0, 0.0, 0.0]),
    "back": np.array([-1.0, 0.0, 0.0]),
    "left": np.array([0.0, 1.0, 0.0]),
    "right": np.array([0.0, -1.0, 0.0]),
}


def pushed_motion(
    name: str, motion: Motion, direction: str, size: float, at: float, duration: float
) -> tuple[wbc.Report, MotionPlayer]:
    """Play a motion during which the torso is pushed for 0.1 s, with noise and estimator.

    Args:
        name: name of the robot.
        motion: motion to be played.
        direction: direction of the push.
        size: impulse, N·s per kg of the robot.
        at: when the push begins, s.
        duration: duration of the run at most, s; it ends when the robot stands idle again.
    """
    one = robot(name)
    player = MotionPlayer(one, motions=[motion])

    def stop_at_rest(time: float) -> None:
        stands = player.walker.gait_state.phase is Phase.STAND
        if time > at + _CAUGHT and stands and player.idle:
            raise RunComplete

    with Mujoco(one, seed=0) as plant:
        plant.schedule_push(at, size * one.mass * DIRECTIONS[direction])
        return wbc.run(player, plant, duration, before_tick=stop_at_rest), player


def assert_feet_side_by_side(player: MotionPlayer) -> None:
    walker = player.walker
    assert walker.gait_state.phase is Phase.STAND
    between = walker.feet.left.to_local(walker.feet.right.point)
    assert abs(between - complex(0.0, -walker.gait.step_width)) < 0.03


@pytest.mark.parametrize("direction", ["forward", "left", slow("back"), slow("right")])
def test_a_robot_on_one_leg_puts_its_foot_down_where_it_catches_a_push(direction):
    motion = OneLeg(leg="left", hold=2.0, impulse=0.0)
    report, player = pushed_motion("g1", motion, direction, 0.35, at=2.6, duration=14.0)
    assert report.survived, report.table()
    assert player.aborted_motions == ("one-leg",)
    assert "one-leg: given up" in player.context.notes[0]
    assert player.idle
    assert_feet_side_by_side(player)


@pytest.mark.parametrize(
    ("name", "motion", "direction"),
    [("g1", Squat(), "forward"), ("talos", Bow(), "left"), ("talos", OneLeg(leg="right"), "back")],
)
def test_a_motion_that_does_not_combine_with_steps_is_given_up_for_them(name, motion, direction):
    report, player = pushed_motion(name, motion, direction, 0.35, at=1.6, duration=12.0)
    assert report.survived, report.table()
    assert player.walker.steps > 0
    assert player.aborted_motions == (motion.name,)
    assert "the robot has to step" in player.context.notes[0]
    assert_feet_side_by_side(player)


def test_a_motion_that_combines_with_walking_goes_on_during_the_steps():
    report, player = pushed_motion("g1", Wave(), "right", 0.4, at=1.5, duration=3.5)
    assert report.survived, report.table()
    assert player.walker.steps > 0
    assert player.aborted_motions == ()


def test_what_the_sole_can_catch_on_one_leg_is_no_reason_to_give_up():
    motion = OneLeg(leg="left", hold=1.5, impulse=0.05)
    report, player = pushed_motion("g1", motion, "forward", 0.1, at=2.4, duration=4.0)
    assert report.survived, report.table()
    assert player.walker.steps == 0
    assert player.aborted_motions == ()

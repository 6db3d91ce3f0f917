"""Motions that are planned in one process and played in another."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

import wbc
from wbc.errors import MotionError
from wbc.motions import (
    Jump,
    Look,
    Motion,
    MotionPlayer,
    Squat,
    Wave,
    once_per_robot,
    pack,
    unpack,
)


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@dataclass(frozen=True)
class Hum(Motion):
    """A motion whose plan is a function, which cannot be pickled."""

    name: ClassVar[str] = "hum"
    summary: ClassVar[str] = "hum"
    checks: ClassVar[list] = []

    def check(self, robot):
        self.checks.append(robot)
        self._tune(robot)

    @once_per_robot
    def _tune(self, robot):
        return lambda time: time

    def play(self, context):
        yield


def torques(robot, motion, ticks=60):
    """Of a robot that stays where it is, whatever is ordered."""
    player = MotionPlayer(robot)
    player.play(motion)
    estimate = wbc.Estimate(robot.standing())
    return np.array([player.step(estimate).tau for _ in range(ticks)])


@pytest.mark.parametrize("motion", [Squat(depth=4.0), Wave(), Look()], ids=lambda m: m.name)
def test_unpacked_motion_plays_identically_without_planning_again(robot, motion, monkeypatch):
    data = pack(motion, robot)
    assert len(data) < 5000  # the robot stays at home
    expected = torques(robot, motion)
    monkeypatch.setattr(type(motion), "check", None)
    monkeypatch.setattr("wbc.ik.posture_ik.PostureIK.solve", None)
    found = unpack(data, robot)
    assert found == motion
    np.testing.assert_array_equal(torques(robot, found), expected)


def test_a_motion_is_checked_once_per_robot(robot):
    Hum.checks.clear()
    motion = Hum()
    player = MotionPlayer(robot, motions=[motion])
    player.play(motion)
    player.blend(motion)
    assert motion.checks == [robot]


def test_plans_that_cannot_be_pickled_are_refused_with_the_cure(robot):
    with pytest.raises(MotionError, match=r"hum cannot be sent .* keep functions"):
        pack(Hum(), robot)


def test_motion_that_the_robot_refuses_is_not_packed(robot):
    with pytest.raises(MotionError, match="clearance"):
        pack(Jump(clearance=-1.0), robot)


def test_requested_push_is_granted_once_in_world_axes(robot):
    player = MotionPlayer(robot)
    state = robot.standing()
    state.q[3:7] = 0.0, 0.0, np.sin(np.pi / 4), np.cos(np.pi / 4)  # heading +y
    player.reset(state)
    player.context.request_push(np.array([0.1, 0.0, 0.0]))
    (due,) = player.pop_pushes()
    np.testing.assert_allclose(due, [0.0, 0.1 * robot.mass, 0.0], atol=1e-9)
    assert player.pop_pushes() == []

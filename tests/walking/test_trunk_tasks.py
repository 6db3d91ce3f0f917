"""How far the torso is turned from its reference, which a motion may turn as well."""

import numpy as np
import pytest

import wbc
from wbc.controller import WholeBodyController
from wbc.walking import WalkerGains
from wbc.walking.reference_offset import ReferenceOffset, RotationOffset
from wbc.walking.trunk_tasks import TrunkTasks


def trunk(name: str, waist: float = 0.0) -> TrunkTasks:
    """Return the tasks of a robot whose waist is turned to the left, rad, once it is built."""
    robot = wbc.load(name)
    kin = wbc.Kinematics(robot, robot.standing())
    tasks = TrunkTasks(WholeBodyController(robot), kin, WalkerGains.for_robot(robot))
    state = robot.standing()
    if waist:
        state.q[7 + robot.joint_index("waist_yaw_joint")] = waist
    kin.update(state)
    return tasks


def test_a_torso_that_was_turned_on_its_waist_is_off_its_reference_by_that_angle():
    tasks = trunk("g1", 0.5)
    tasks.update(0.2, 0.0, None)
    assert tasks.torso_turn() == pytest.approx(0.3)


def test_a_torso_that_a_motion_turns_is_where_it_is_to_be():
    tasks = trunk("g1", 0.5)
    turned = RotationOffset(is_zero=False, vector=np.array((0.0, 0.0, 0.5)))
    tasks.update(0.0, 0.0, ReferenceOffset(torso=turned))
    assert tasks.torso_turn() == pytest.approx(0.0, abs=1e-9)


def test_a_torso_that_is_the_base_has_no_waist_to_turn_on():
    tasks = trunk("bolt")
    tasks.update(0.5, 0.0, None)
    assert len(tasks.tasks) == 1
    assert tasks.torso_turn() == 0.0

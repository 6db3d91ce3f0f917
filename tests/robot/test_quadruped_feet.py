"""The four feet of a quadruped: found by their names, or stated."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.errors import GaitError, RobotDescriptionError
from wbc.gait import check_walking

SIDES = ("front_left", "front_right", "hind_left", "hind_right")
FEET = {
    "solo12": ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"),
    "go2": ("FL_foot", "FR_foot", "RL_foot", "RR_foot"),
    "hyq_no_sensors": ("lf_foot", "rf_foot", "lh_foot", "rh_foot"),
    "go1": ("FL_foot", "FR_foot", "RL_foot", "RR_foot"),
    "laikago": ("FL_foot", "FR_foot", "RL_foot", "RR_foot"),
}


@pytest.mark.parametrize("name", FEET)
def test_a_quadruped_stands_level_on_four_feet_that_its_names_tell(name: str) -> None:
    robot = wbc.load(name)
    assert robot.is_quadruped
    assert tuple(sole.link for sole in robot.soles) == FEET[name]
    assert tuple(sole.side for sole in robot.soles) == SIDES
    assert [len(leg) for leg in robot.legs] == [3, 3, 3, 3]
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_nominal)
    places = np.array([data.oMf[sole.frame_id].translation for sole in robot.soles])
    assert np.abs(places[:, 2]).max() < 1e-4
    assert (places[:, 0] > 0.0).tolist() == [True, True, False, False]
    assert (places[:, 1] > 0.0).tolist() == [True, False, True, False]
    com = pin.centerOfMass(robot.model, data, robot.q_nominal)
    assert np.abs(com[:2]).max() < 0.01 * robot.com_height
    assert not [finding for finding in robot.check() if finding.severity == "error"]
    assert not check_walking(robot)


def test_the_four_feet_may_be_stated() -> None:
    robot = wbc.load("solo12", feet=FEET["solo12"])
    assert [fact.origin for fact in robot.facts if fact.name == "hind left foot"] == ["stated"]
    with pytest.raises(RobotDescriptionError, match="both feet and left_foot"):
        wbc.load("solo12", feet=FEET["solo12"], left_foot="FL_FOOT", right_foot="FR_FOOT")
    with pytest.raises(RobotDescriptionError, match="hind right foot is stated as 'tail'"):
        wbc.load("solo12", feet=(*FEET["solo12"][:3], "tail"))


def test_two_feet_that_are_stated_make_a_robot_on_two_feet() -> None:
    assert not wbc.load("solo12", left_foot="FL_FOOT", right_foot="FR_FOOT").is_quadruped


def test_a_walker_of_the_other_kind_says_so() -> None:
    with pytest.raises(GaitError, match=r"has four feet.*wbc\.QuadrupedWalker"):
        wbc.Walker(wbc.load("solo12"))
    with pytest.raises(GaitError, match=r"walks with wbc\.Walker"):
        wbc.QuadrupedWalker(wbc.load("bolt"))


def test_legs_that_cannot_trot_are_told_with_the_bound() -> None:
    with pytest.raises(GaitError, match=r"has 2 joints, and to place a foot .* takes 3"):
        wbc.QuadrupedWalker(wbc.load("solo"))
    joints = wbc.load("solo12").joint_names
    weak = wbc.load("solo12", effort_limits=dict.fromkeys(joints, 0.3))
    [finding] = check_walking(weak)
    assert finding.code == "cannot-walk"
    assert "has 0.3 N·m" in finding.what

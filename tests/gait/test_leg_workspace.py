"""Workspace of the legs: knees, reach, CoM height and length of steps."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.gait import GaitParameters
from wbc.gait.leg_workspace import LegWorkspace


@pytest.mark.parametrize(
    ("name", "knees"),
    [
        ("talos", ("leg_left_4_joint", "leg_right_4_joint")),
        ("g1", ("left_knee_joint", "right_knee_joint")),
        ("romeo", ("LKneePitch", "RKneePitch")),
        ("simple_humanoid", ("left_knee", "right_knee")),
    ],
)
def test_knees_are_found_and_long_steps_lower_the_com(name: str, knees: tuple[str, str]) -> None:
    robot = wbc.load(name)
    reach = LegWorkspace(robot)
    assert tuple(robot.joint_names[k] for k in reach.knees) == knees
    heights = [reach.com_height(step) for step in np.linspace(0.0, 0.5 * robot.leg_length, 12)]
    assert all(low <= high + 1e-12 for high, low in itertools.pairwise(heights))
    assert heights[0] <= robot.com_height + 1e-12
    assert 0.7 * robot.com_height < heights[-1] < heights[0]


def test_a_leg_that_ends_with_its_knee_reaches_to_its_sole() -> None:
    robot = wbc.load("bolt", left_foot="FL_FOOT", right_foot="FR_FOOT")
    workspace = LegWorkspace(robot)
    assert tuple(robot.joint_names[k] for k in workspace.knees) == ("FL_KFE", "FR_KFE")
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_nominal)
    sole = robot.soles[0]
    hip = data.oMi[robot.model.getJointId("FL_HAA")].translation
    nominal = float(np.linalg.norm(data.oMf[sole.frame_id].translation - hip))
    assert 0.8 * nominal < workspace.reach < 1.3 * nominal


def test_knees_that_carry_little_more_than_the_robot_allow_only_short_steps() -> None:
    romeo, talos = wbc.load("romeo"), wbc.load("talos")
    assert GaitParameters.for_robot(romeo).max_step < 0.3 * romeo.leg_length
    assert GaitParameters.for_robot(talos).max_step == pytest.approx(0.51 * talos.com_height)


def test_leg_reach_is_the_distance_from_hip_to_ankle_with_a_bent_knee() -> None:
    robot = wbc.load("simple_humanoid")
    data = robot.model.createData()
    q = robot.q_nominal.copy()
    q[7 + robot.joint_index("left_knee")] = 0.6  # straight is 0
    pin.forwardKinematics(robot.model, data, q)
    hip = data.oMi[robot.model.getJointId("left_hip_yaw")].translation
    ankle = data.oMi[robot.model.getJointId("left_ankle_roll")].translation
    assert LegWorkspace(robot).reach == pytest.approx(float(np.linalg.norm(hip - ankle)), abs=0.01)


def test_feet_spread_no_farther_than_the_ankles_roll() -> None:
    robot = wbc.load("g1")
    reach = LegWorkspace(robot)
    roll = robot.q_max[robot.joint_index("left_ankle_roll_joint")]
    hip_height = 0.62  # m, of G1's hip pitch over its ankle
    # Off its hip by 0.7 of the extra distance, the leg leans; the ankle must undo it.
    assert math.atan2(0.7 * reach.max_spread, hip_height) < roll - 0.05
    assert GaitParameters.for_robot(robot).max_side_step == pytest.approx(reach.max_spread)

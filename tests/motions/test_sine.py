"""The sine pattern: its values and the joints that it moves."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from coretools import robot

from wbc.motions.sine import match_joints, pattern

ROBOTS = ("talos", "g1", "simple_humanoid", "romeo", "icub")


@pytest.mark.parametrize("name", ROBOTS)
def test_sine_pattern_finds_its_fifteen_joints(name):
    one = robot(name)
    joints, missing = match_joints(one)
    assert {*joints, *missing} == set(pattern(0.0))
    assert len({index for index, _ in joints.values()}) == len(joints)
    if name == "simple_humanoid":
        assert all(one.joint_names[index] == key for key, (index, _) in joints.items())
    data = one.model.createData()
    pin.computeJointJacobians(one.model, data, one.q_nominal)
    for key, axis in (("left_hip_pitch", 1), ("right_knee", 1), ("left_ankle_roll", 0)):
        index, sign = joints[key]
        assert sign * data.J[3 + axis, 6 + index] > 0.6


def test_sine_pattern_equals_that_of_the_tutorial():
    now = pattern(0.5)
    right, left = np.sin(0.5), np.sin(0.5 + np.pi)
    assert now["torso_yaw"] == pytest.approx(0.1 * np.sin(1.0))
    assert now["right_hip_pitch"] == pytest.approx(0.3 * right)
    assert now["right_knee"] == pytest.approx(0.5 * right)
    assert now["left_knee"] == 0.0
    assert now["left_ankle_pitch"] == pytest.approx(-0.3 * left)
    assert now["left_shoulder_pitch"] == pytest.approx(-0.2 * left)
    assert now["right_elbow"] == now["left_elbow"] == 0.1
    assert len(now) == 15

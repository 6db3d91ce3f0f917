"""Arms, head and waist are found in the kinematic tree of any robot."""

from __future__ import annotations

import numpy as np
import pytest
from coretools import robot

import wbc
from wbc.errors import MotionError
from wbc.robot.upper_body import UpperBody

ROBOTS = ("talos", "g1", "simple_humanoid", "romeo", "icub")


@pytest.mark.parametrize("name", ROBOTS)
def test_arms_are_found_on_both_sides_and_end_in_hands(name):
    upper_body = UpperBody.of(robot(name))
    kin = wbc.Kinematics(robot(name), robot(name).standing())
    left, right = upper_body.both_arms()
    assert len(left.joints) == len(right.joints) >= 3
    assert not set(left.joints) & set(right.joints)
    in_legs = {j - 6 for leg in robot(name).legs for j in leg}
    assert not in_legs & {*left.joints, *right.joints, *upper_body.waist}
    assert left.length == pytest.approx(right.length, rel=1e-3)
    places = [kin.frame(arm.hand).translation for arm in (left, right)]
    assert places[0][1] > 0.1 > -0.1 > places[1][1]
    for arm, place in zip((left, right), places, strict=True):
        shoulder = kin.frame(arm.shoulder).translation
        assert shoulder[2] > place[2]  # it hangs
        assert np.linalg.norm(place - shoulder) <= arm.length + 1e-9


def test_head_and_waist_joints_are_found_in_the_models():
    talos, g1, own = (UpperBody.of(robot(n)) for n in ("talos", "g1", "simple_humanoid"))
    assert [robot("talos").joint_names[j] for j in talos.head.joints] == [
        "head_1_joint",
        "head_2_joint",
    ]
    assert g1.head is None
    assert [robot("g1").joint_names[j] for j in g1.waist] == [
        "waist_yaw_joint",
        "waist_roll_joint",
        "waist_pitch_joint",
    ]
    assert own.waist_range[:2] == pytest.approx(0.0)
    assert own.waist_range[2] == pytest.approx([-1.2, 1.2])
    # What the waist cannot do the hips do.
    assert own.hips_share(np.array([0.0, 0.4, 0.3])) == pytest.approx([0.0, 0.4, 0.0])
    assert g1.hips_share(np.array([0.0, 0.4, 0.0])) == pytest.approx([0.0, 0.2, 0.0])


def test_a_missing_arm_is_an_error_that_names_it():
    upper_body = UpperBody.of(robot("talos"))
    lame = UpperBody(upper_body.robot, upper_body.arms[:1], None, (), np.zeros((3, 2)))
    with pytest.raises(MotionError, match=r"no right arm \(it has: left\)"):
        lame.both_arms()

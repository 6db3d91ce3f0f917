"""What motions know of a robot: arms, head, waist, postures, torques, all read off the model."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from coretools import robot

import wbc
from wbc.errors import MotionError
from wbc.ik.objective import PostureObjective
from wbc.ik.posture_checks import holding_effort, support_half_size
from wbc.ik.posture_ik import PostureIK
from wbc.motions.sine import match_joints, pattern
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


def test_head_and_waist_are_what_the_models_have():
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


def test_a_missing_arm_is_said():
    upper_body = UpperBody.of(robot("talos"))
    lame = UpperBody(upper_body.robot, upper_body.arms[:1], None, (), np.zeros((3, 2)))
    with pytest.raises(MotionError, match=r"no right arm \(it has: left\)"):
        lame.both_arms()


@pytest.mark.parametrize("name", ROBOTS)
def test_hands_are_posed_where_some_posture_of_the_arms_had_them(name):
    one, random = robot(name), np.random.default_rng(4)
    ik = PostureIK(one)
    arms = ik.upper_body.both_arms()
    for _ in range(3):
        q = one.q_nominal.copy()
        for arm in arms:
            joints = np.array(arm.joints)
            low, high = one.q_min[joints], one.q_max[joints]
            q[7 + joints] = low + random.uniform(0.2, 0.8, joints.size) * (high - low)
        hands = {arm.hand: ik.frame_position(arm.hand, q) for arm in arms}
        pose = ik.solve(PostureObjective(hands=hands))
        assert max(pose.hand_errors.values()) < 1e-3
        for arm in arms:
            assert ik.frame_position(arm.hand, pose.q) == pytest.approx(hands[arm.hand], abs=1e-3)
        assert (pose.q[7:] >= one.q_min - 1e-9).all()
        assert (pose.q[7:] <= one.q_max + 1e-9).all()
        for sole in one.soles:  # the feet have not moved
            assert ik.frame_position(sole.name, pose.q) == pytest.approx(
                ik.frame_position(sole.name), abs=1e-3
            )


def test_a_place_out_of_reach_is_missed_by_what_is_left():
    ik = PostureIK(robot("talos"))
    arm = ik.upper_body.arm("left")
    far = ik.frame_position(arm.shoulder) + np.array([arm.length + 1.0, 0.0, 0.0])
    pose = ik.solve(PostureObjective(hands={arm.hand: far}))
    closest_posture = ik.frame_position(arm.hand, pose.q)
    assert pose.hand_errors[arm.hand] == pytest.approx(
        np.linalg.norm(far - closest_posture), abs=1e-6
    )
    assert 0.3 < pose.hand_errors[arm.hand] < 1.0  # it leans forward, but only so far


@pytest.mark.parametrize("name", ["talos", "g1", "simple_humanoid"])
def test_a_squat_lowers_the_com_and_nothing_else(name):
    ik = PostureIK(robot(name))
    down = np.array([0.0, 0.0, -0.1 * robot(name).leg_length])
    pose = ik.solve(PostureObjective(com=down, strict_trunk=True, strict_com=True))
    assert pose.com_error < 1e-4
    assert np.abs(pose.torso).max() < 1e-3
    assert np.abs(pose.pelvis).max() < 1e-3
    _, miss, tilt = ik.place_on_left_sole(pose.q)
    assert miss < 1e-4
    assert tilt < 1e-4


@pytest.mark.parametrize("name", ["talos", "g1"])
def test_static_torques_hold_the_robot_still(name):
    one = robot(name)
    need = holding_effort(one, one.q_nominal)
    # With these torques and some forces under the soles nothing accelerates.
    kin = wbc.Kinematics(one, one.standing())
    J = np.vstack([kin.jacobian(sole.name) for sole in one.soles])
    tau = np.concatenate((np.zeros(6), need.torque))
    force, *_ = np.linalg.lstsq(J.T, kin.bias_forces - tau, rcond=None)
    assert J.T @ force == pytest.approx(kin.bias_forces - tau, abs=1e-6)
    assert force[2] + force[8] == pytest.approx(one.weight)
    assert need.ratio == pytest.approx((np.abs(need.torque) / one.tau_max).max())
    one_leg = holding_effort(one, one.q_nominal, weight_shift=1.0)
    assert one_leg.ratio > need.ratio


def test_the_support_is_the_rectangle_around_both_soles():
    half = support_half_size(robot("simple_humanoid"))
    assert half == pytest.approx([0.11, 0.15], abs=0.002)


@pytest.mark.parametrize("name", ROBOTS)
def test_the_sine_pattern_finds_its_fifteen_joints(name):
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


def test_the_sine_pattern_is_the_tutorials():
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

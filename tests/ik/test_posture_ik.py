"""Inverse kinematics of postures, holding torques and the size of the support."""

from __future__ import annotations

import numpy as np
import pytest
from coretools import robot

import wbc
from wbc.ik.objective import PostureObjective
from wbc.ik.posture_checks import holding_effort, support_half_size
from wbc.ik.posture_ik import PostureIK

ROBOTS = ("talos", "g1", "simple_humanoid", "romeo", "icub")


@pytest.mark.parametrize("name", ROBOTS)
def test_hands_reach_positions_taken_from_reachable_postures(name):
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


def test_a_target_out_of_reach_is_missed_by_its_distance_to_the_workspace():
    ik = PostureIK(robot("talos"))
    arm = ik.upper_body.arm("left")
    far = ik.frame_position(arm.shoulder) + np.array([arm.length + 1.0, 0.0, 0.0])
    pose = ik.solve(PostureObjective(hands={arm.hand: far}))
    nearest = ik.frame_position(arm.hand, pose.q)
    assert pose.hand_errors[arm.hand] == pytest.approx(np.linalg.norm(far - nearest), abs=1e-6)
    assert 0.3 < pose.hand_errors[arm.hand] < 1.0  # it leans forward, but only so far


@pytest.mark.parametrize("name", ["talos", "g1", "simple_humanoid"])
def test_a_squat_changes_only_the_com_height(name):
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


def test_support_half_size_spans_both_soles():
    half = support_half_size(robot("simple_humanoid"))
    assert half == pytest.approx([0.11, 0.15], abs=0.002)

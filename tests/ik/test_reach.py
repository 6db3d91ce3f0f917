"""Search for postures that reach targets."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from coretools import robot

import wbc
from wbc.errors import TaskError
from wbc.ik import InverseKinematics, InverseKinematicsError
from wbc.robot.upper_body import UpperBody


def arm_of(name: str) -> tuple[wbc.robot.RobotModel, list[str], str]:
    if name == "panda":
        one = wbc.load_fixed_base("panda")
        return one, list(one.joint_names[:7]), "panda_hand"
    one = robot(name)
    arm = UpperBody.of(one).arm("left")
    return one, [one.joint_names[j] for j in arm.joints], arm.hand


@pytest.mark.parametrize("name", ["panda", "talos", "g1"])
def test_an_arm_reaches_random_reachable_poses(name):
    one, joints, frame = arm_of(name)
    ik = InverseKinematics(one, joints=joints)
    hand = ik.add(wbc.FrameTask(frame))
    index = np.array([one.joint_index(joint) for joint in joints])
    limit, random = ik.limits[0], np.random.default_rng(3)
    for k in range(15):
        q = one.q_nominal.copy()
        q[7 + index] = random.uniform(limit.lower[index], limit.upper[index])
        data = one.model.createData()
        pin.framesForwardKinematics(one.model, data, q)
        hand.target = data.oMf[one.frame_id(frame)].copy()
        found = ik.reach(one.q_nominal, seed=k)
        assert found.reached, found
        assert found.explanation == ""
        pin.framesForwardKinematics(one.model, data, found.q)
        off = hand.target.actInv(data.oMf[one.frame_id(frame)])
        assert np.linalg.norm(pin.log6(off).vector) < 5e-5
        assert (found.q[7:] <= limit.upper + 1e-9)[index].all()
        assert (found.q[7:] >= limit.lower - 1e-9)[index].all()
        still = np.setdiff1d(np.arange(one.na), index)
        assert (found.q[7 + still] == one.q_nominal[7 + still]).all()


def test_the_whole_body_reaches_in_balance_and_stays_near_its_posture():
    one = robot("talos")
    ik = InverseKinematics(one)
    for sole in one.soles:
        ik.add(wbc.FrameTask(sole.name, priority=0))
    ik.add(wbc.ComTask())
    hand = ik.add(wbc.PositionTask(UpperBody.of(one).arm("left").hand))
    ik.step(one.q_nominal, 0.01)
    hand.target = hand.target + np.array([0.15, 0.1, 0.2])
    far = ik.reach(one.q_nominal)
    posture = ik.add(wbc.PostureTask(one))
    near = ik.reach(one.q_nominal)
    assert far.reached
    assert near.reached

    def distance(q: np.ndarray) -> float:
        return float(np.linalg.norm(q[7:] - posture.target))

    assert distance(near.q) < 0.999 * distance(far.q)


def test_what_cannot_be_reached_is_told_with_the_limits_in_the_way():
    one = wbc.load_fixed_base("panda")
    ik = InverseKinematics(one, joints=["panda_joint1"])
    hand = ik.add(wbc.PositionTask("panda_hand"))
    ik.step(one.q_nominal, 0.01)
    turned = pin.exp3(np.array([0.0, 0.0, 3.1])) @ hand.target
    hand.target = turned
    found = ik.reach(one.q_nominal, restarts=2)
    assert not found.reached
    assert found.attempts == 3
    assert "'panda_hand position' misses its target by" in found.explanation
    assert "joint position limit [panda_joint1]" in found.explanation
    assert np.abs(found.errors["panda_hand position"]).max() > 1e-2
    free = InverseKinematics(one)
    free.add(wbc.PositionTask("panda_hand", (3.0, 0.0, 0.0)))
    assert "mm; " in free.reach(one.q_nominal, restarts=1).explanation


def test_of_targets_that_exclude_each_other_the_lower_level_comes_as_near_as_it_can():
    one = wbc.load_fixed_base("panda")
    ik = InverseKinematics(one)
    hand = ik.add(wbc.PositionTask("panda_hand", (0.5, 0.2, 0.5), priority=2))
    elbow = ik.add(wbc.PositionTask("panda_link4"))
    ik.step(one.q_nominal, 0.01)
    hand.target = hand.target + np.array([3.0, 0.0, 0.0])  # out of reach
    found = ik.reach(one.q_nominal, restarts=1)
    assert not found.reached
    assert "'panda_hand position' misses its target by" in found.explanation
    assert "panda_link4" not in found.explanation
    assert np.abs(found.errors["panda_link4 position"]).max() <= 1e-5
    near = np.linalg.norm(found.errors["panda_hand position"])
    hand.priority, elbow.priority = 1, 2
    nearest = np.linalg.norm(ik.reach(one.q_nominal, restarts=1).errors["panda_hand position"])
    assert nearest < near


def test_arguments_of_a_search_are_checked():
    one = wbc.load_fixed_base("panda")
    ik = InverseKinematics(one, joints=one.joint_names[:7])
    with pytest.raises(InverseKinematicsError, match="0 targets"):
        ik.reach(one.q_nominal)
    ik.add(wbc.PositionTask("panda_hand"))
    with pytest.raises(InverseKinematicsError, match="tolerance -1"):
        ik.reach(one.q_nominal, tolerance=-1.0)
    with pytest.raises(TaskError, match="none of the tasks"):
        ik.reach(one.q_nominal, targets=[wbc.ComTask()])

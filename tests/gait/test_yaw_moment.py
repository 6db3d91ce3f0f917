"""The moment about the vertical of a swing leg."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.gait.limb_momentum import arm_yaw_momentum
from wbc.gait.yaw_moment import YawMoment
from wbc.robot.upper_body import UpperBody


def test_a_sole_lacks_more_of_the_moment_the_faster_the_swing() -> None:
    moment = YawMoment(wbc.load("g1"))
    shares = [moment.beyond_sole(0.4, swing) for swing in (0.8, 0.5, 0.4, 0.3)]
    assert shares[0] == 0.0
    assert shares == sorted(shares)
    assert 0.3 < shares[-1] < 1.0
    assert moment.beyond_sole(0.0, 0.3) == 0.0


def test_arms_that_swing_leave_less_for_the_sole() -> None:
    moment = YawMoment(wbc.load("g1"))
    held = moment.excess(0.42, 0.42, np.inf)
    assert moment.excess(0.42, 0.42, 0.48) < held
    assert held > 0.0


def test_a_robot_without_arms_makes_no_momentum_by_them() -> None:
    assert arm_yaw_momentum(wbc.load("bolt")) == 0.0


@pytest.mark.parametrize("name", ["talos", "g1", "simple_humanoid"])
def test_arm_momentum_is_that_of_both_arms_swung_against_each_other(name: str) -> None:
    robot = wbc.load(name)
    model, q = robot.model, robot.standing().q
    data = model.createData()
    joints = [6 + index for arm in UpperBody.of(robot).arms for index in arm.joints]
    total = 0.0
    for joint in joints:  # the momentum of each joint alone, from the bodies' motion
        v = np.zeros(model.nv)
        v[joint] = 1.0
        total += abs(float(pin.computeCentroidalMomentum(model, data, q, v).angular[2]))
    assert arm_yaw_momentum(robot) == pytest.approx(total, rel=1e-9)

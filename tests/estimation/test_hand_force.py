"""Forces on hands and masses of payloads, from torques and from the forces on the feet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from coretools import robot

import wbc
from wbc.errors import MeasurementError
from wbc.estimation import Estimate, HandForceEstimator, PayloadEstimator
from wbc.robot.upper_body import UpperBody


@pytest.mark.parametrize("name", ["talos", "g1"])
def test_the_torques_of_a_resting_arm_tell_the_force_on_its_hand(name):
    bot = robot(name)
    arm = UpperBody.of(bot).arm("left")
    kin = wbc.Kinematics(bot, bot.standing())
    force = np.array([-20.0, 5.0, 10.0])
    torque = (kin.bias_forces - kin.jacobian(arm.hand)[:3].T @ force)[6:]
    estimator = HandForceEstimator(bot, 0.002, arm.hand, arm.joints, time_constant=0.05)
    for _ in range(25):
        estimator.update(kin, torque)
    half = estimator.force.copy()
    for _ in range(250):
        estimator.update(kin, torque)
    np.testing.assert_allclose(estimator.force, force, atol=2.0)
    # A low-pass: after one time constant it has seen 63 %.
    assert half[0] / estimator.force[0] == pytest.approx(0.63, abs=0.03)


@pytest.mark.parametrize("sensors", [True, False], ids=["foot forces", "arm torques"])
def test_the_payload_is_what_the_robot_carries_beyond_its_weight(sensors):
    bot = robot("g1")
    kin = wbc.Kinematics(bot, bot.standing())
    each = np.array([0.0, 0.0, 0.5 * (bot.mass + 3.0) * bot.gravity, 0.0, 0.0, 0.0])
    estimate = Estimate(bot.standing())
    if sensors:
        estimate = replace(estimate, foot_wrenches={sole.name: each for sole in bot.soles})
    estimator = PayloadEstimator(bot, 0.002, time_constant=0.2)
    assert not estimator.settled
    for _ in range(700):
        estimator.update(estimate, kin, np.array([0.0, 0.0, -3.0 * bot.gravity]))
    assert estimator.mass == pytest.approx(3.0, rel=1e-3)
    assert estimator.settled


def test_estimators_without_a_time_constant_are_refused():
    bot = robot("g1")
    arm = UpperBody.of(bot).arm("left")
    with pytest.raises(MeasurementError, match=r"time_constant = 0.0 s must be positive"):
        HandForceEstimator(bot, 0.002, arm.hand, arm.joints, time_constant=0.0)
    with pytest.raises(MeasurementError, match="at least one"):
        HandForceEstimator(bot, 0.002, arm.hand, ())
    with pytest.raises(MeasurementError, match=r"time_constant = -1.0 s must be positive"):
        PayloadEstimator(bot, 0.002, time_constant=-1.0)

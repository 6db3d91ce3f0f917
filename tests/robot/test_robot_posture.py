"""The nominal posture: what is stated holds, what is not is derived."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from robottools import FEET, SIMPLE, changed

import wbc
import wbc.robot


def positions(robot, *names):
    return [robot.q_nominal[7 + robot.joint_index(name)] for name in names]


def soles_are_flat(robot):
    """Both level on z = 0."""
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, robot.q_nominal)
    placements = [data.oMf[sole.frame_id] for sole in robot.soles]
    level = [np.allclose(T.rotation[:, 2], [0.0, 0.0, 1.0], atol=1e-8) for T in placements]
    return all(level) and all(abs(T.translation[2]) < 1e-8 for T in placements)


def stands(robot):
    """Soles level on z = 0 and the centre of mass above their midpoint."""
    com = pin.centerOfMass(robot.model, robot.model.createData(), robot.q_nominal)
    return soles_are_flat(robot) and abs(com[0]) < 0.005 and abs(com[1]) < 0.005


@pytest.mark.parametrize("bend", [0.3, 0.8, 1.2])
def test_stated_knees_hold_and_the_other_leg_joints_make_the_soles_flat(bend):
    robot = wbc.robot.load(
        "simple_humanoid", nominal_posture={"left_knee": bend, "right_knee": bend}
    )
    assert positions(robot, "left_knee", "right_knee") == [bend, bend]
    assert stands(robot)
    assert robot.check() == []


def test_a_posture_that_states_no_leg_joint_stands_on_bent_knees():
    robot = wbc.robot.load("simple_humanoid", nominal_posture={"left_elbow": 0.5})
    assert positions(robot, "left_elbow") == [0.5]
    assert min(positions(robot, "left_knee", "right_knee")) > 0.3
    assert stands(robot)


def test_a_full_leg_posture_without_flat_soles_is_corrected_with_a_finding():
    stated = {
        f"{side}_{joint}": value
        for side in ("left", "right")
        for joint, value in (
            ("hip_yaw", 0.0), ("hip_roll", 0.0), ("hip_pitch", -0.2),
            ("knee", 0.5), ("ankle_pitch", -0.2), ("ankle_roll", 0.0),
        )
    }  # fmt: skip
    robot = wbc.robot.load("simple_humanoid", nominal_posture=stated)
    assert soles_are_flat(robot)
    fact = next(fact for fact in robot.facts if fact.name == "nominal posture")
    assert "legs corrected" in fact.value


def test_joints_left_out_whose_range_has_no_zero_stay_at_the_nearest_limit(tmp_path):

    path = changed(
        tmp_path, ('lower="-1.57" upper="1.57" effort="10"', 'lower="0.3" upper="1.57" effort="10"')
    )
    robot = wbc.robot.load(path, **FEET, nominal_posture={"left_knee": 0.5, "right_knee": 0.5})
    assert (robot.q_nominal[7:] >= robot.q_min).all()
    assert 0.3 in robot.q_nominal[7:]


def test_knees_that_cannot_bend_as_usual_are_bent_less_rather_than_the_legs_spread(tmp_path):
    old = '<axis xyz="0 1 0"/><limit lower="-1" upper="0.8" effort="120" velocity="10"/>'
    new = old.replace('lower="-1"', 'lower="-0.15"')
    robot = wbc.robot.load(changed(tmp_path, (old, new), (old, new)), **FEET)
    assert stands(robot)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_nominal)
    left, right = (data.oMf[sole.frame_id].translation for sole in robot.soles)
    assert 0.15 < left[1] - right[1] < 0.35


def test_feet_that_would_overlap_are_put_side_by_side():
    sole = {"height": -0.08, "length": 0.22, "width": 0.24}
    robot = wbc.robot.load("simple_humanoid", nominal_posture={"left_elbow": 0.0}, sole=sole)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_nominal)
    left, right = (data.oMf[sole.frame_id].translation for sole in robot.soles)
    assert left[1] - right[1] > 0.24
    assert "overlapping-soles" not in {finding.code for finding in robot.check()}


def test_a_knee_is_bent_from_where_the_leg_is_straight(tmp_path):
    origin = '<child link="{}_shin"/><origin xyz="0 0 -0.38"'
    turned = [
        (origin.format(side), f'{origin.format(side)} rpy="0 -0.3 0"') for side in ("left", "right")
    ]
    straight, bent = wbc.load(SIMPLE), wbc.load(changed(tmp_path, *turned))
    # The shank's own frame is turned by 0.3 rad, so that the ankle must turn by as much the less.
    for robot, knee in ((straight, 0.4), (bent, 0.7)):
        assert robot.q_nominal[7 + robot.joint_index("left_knee")] == pytest.approx(knee, abs=0.06)

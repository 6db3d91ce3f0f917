"""A robot that cannot walk is told why, with the joint and the bound, before it falls."""

from __future__ import annotations

import re

import pytest
from robottools import FEET, changed

import wbc
from wbc.errors import GaitError
from wbc.gait import GaitParameters, check_walking
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.step_motion import StepMotion
from wbc.gait.strength import support_effort


def weak(joint: str, effort: float) -> wbc.Robot:
    limits = {f"{side}_{joint}": effort for side in ("left", "right")}
    return wbc.load("simple_humanoid", effort_limits=limits)


@pytest.mark.parametrize("name", ["talos", "g1", "simple_humanoid"])
def test_a_strong_robot_has_nothing_that_holds_its_walk_back(name: str) -> None:
    assert check_walking(wbc.load(name)) == []


@pytest.mark.parametrize(("joint", "effort"), [("knee", 40.0), ("hip_roll", 45.0)])
def test_a_joint_too_weak_for_one_leg_is_named_with_its_bound(joint: str, effort: float) -> None:
    robot = weak(joint, effort)
    with pytest.raises(GaitError, match=rf"'(left|right)_{joint}' has {effort:g} N·m.* takes"):
        wbc.Walker(robot)
    (finding,) = check_walking(robot)
    assert finding.code == "cannot-walk"
    bound = float(re.findall(r"takes ([\d.]+) N·m", finding.what)[0])
    GaitParameters.for_robot(weak(joint, 1.05 * bound))  # enough
    with pytest.raises(GaitError):
        GaitParameters.for_robot(weak(joint, 0.85 * bound))


def test_a_leg_at_its_limit_is_a_finding_that_leaves_it_walking() -> None:
    (finding,) = check_walking(weak("hip_roll", 56.0))
    assert (finding.code, finding.severity) == ("weak-leg", "warning")
    assert "94 %" in finding.what


def test_the_effort_on_one_leg_is_the_weight_times_the_lever_of_the_hip() -> None:
    robot = wbc.load("simple_humanoid")
    workspace = LegWorkspace(robot)
    gait = GaitParameters.for_robot(robot)
    effort = support_effort(robot, StepMotion(robot, workspace), gait)
    assert effort.joint in ("left_hip_roll", "right_hip_roll")
    # The hip carries all but the leg itself, half a step width beside it.
    most = 0.5 * gait.step_width * robot.weight
    assert 0.7 * most < effort.torque < 1.3 * most


def test_a_joint_that_hardly_moves_names_what_slows_the_walk(tmp_path) -> None:
    old = '<axis xyz="1 0 0"/><limit lower="-0.5" upper="0.8" effort="150" velocity="8"/>'
    new = old.replace('velocity="8"', 'velocity="0.2"')
    robot = wbc.load(changed(tmp_path, (old, new)), **FEET)
    findings = {f.subject: f for f in check_walking(robot)}
    assert "reaches its velocity limit" in findings["left_hip_roll"].what
    assert "to the side" in findings["left_hip_roll"].what


@pytest.mark.parametrize("joint", ["*hip_pitch", "*hip_roll"])
def test_legs_that_cannot_lift_a_foot_and_keep_it_level_are_refused(joint: str) -> None:
    robot = wbc.load("simple_humanoid", fixed_joints=[joint])
    with pytest.raises(
        GaitError, match=r"lifted by 0\.0\d+ m, its legs cannot hold both soles level"
    ):
        wbc.Walker(robot)
    assert [finding.code for finding in check_walking(robot)] == ["cannot-walk"]


@pytest.mark.parametrize(
    ("fixed", "share"), [(["*ankle_roll"], 0.5), (["*ankle_roll", "*hip_yaw"], 0.25)]
)
def test_each_joint_that_a_leg_lacks_halves_its_velocities(fixed: list[str], share: float) -> None:
    whole = GaitParameters.for_robot(wbc.load("simple_humanoid")).max_velocity
    robot = wbc.load("simple_humanoid", fixed_joints=fixed)
    limits = GaitParameters.for_robot(robot).max_velocity
    assert limits.forward == pytest.approx(share * whole.forward, rel=0.1)


def test_soles_that_overlap_are_a_finding_and_the_gait_keeps_them_apart() -> None:
    robot = wbc.load("simple_humanoid", sole={"height": -0.08, "length": 0.22, "width": 0.24})
    assert "overlapping-soles" in {f.code for f in robot.check()}
    gait = GaitParameters.for_robot(robot)
    assert gait.least_width >= 0.24
    assert gait.step_width >= gait.least_width


def test_parameters_are_computed_once_per_robot() -> None:
    robot = weak("knee", 200.0)
    assert GaitParameters.for_robot(robot) is GaitParameters.for_robot(robot)
    assert GaitParameters.for_robot(weak("knee", 200.0)) == GaitParameters.for_robot(robot)

"""Descriptions in other languages than URDF, and by the names of robot_descriptions."""

from __future__ import annotations

import sys
import types

import numpy as np
import pinocchio as pin
import pytest
from robottools import FEET, SIMPLE

import wbc
from wbc.errors import MissingExtra, RobotDescriptionError, RobotNotFound
from wbc.robot.description import read_description

BIPED = """<mujoco model="biped">
  <compiler angle="radian"/>
  <worldbody><body name="base">
    <freejoint/><geom type="box" size=".1 .1 .1" mass="5"/>
    <body name="left_thigh" pos="0 .1 -.1">
      <joint name="left_hip_roll" axis="1 0 0" range="-1 1" actuatorfrcrange="-50 50"/>
      <joint name="left_hip_pitch" axis="0 1 0" range="-1 1.5"/>
      <geom type="capsule" fromto="0 0 0 0 0 -.3" size=".03" mass="1"/>
      <body name="left_foot" pos="0 0 -.3">
        <joint name="left_ankle" type="slide" axis="0 0 1" range="0 .2"/>
        <geom type="box" size=".1 .05 .01" mass=".5"/>
      </body>
    </body>
  </body></worldbody>
  <actuator><motor joint="left_hip_pitch" ctrlrange="-20 30" gear="2"/></actuator>
</mujoco>"""


def mjcf_of_simple_humanoid(path):
    """Let MuJoCo write its own language from the URDF, with a floating base."""
    mujoco = pytest.importorskip("mujoco")
    base = wbc.load("simple_humanoid").base
    floating = (
        '<mujoco><compiler fusestatic="false" discardvisual="false"/></mujoco>'
        '<link name="world"/><joint name="free" type="floating">'
        f'<parent link="world"/><child link="{base}"/></joint>'
    )
    head, middle, rest = SIMPLE.read_text().partition("<link ")
    spec = mujoco.MjSpec.from_string(head + floating + middle + rest)
    spec.compile()
    path.write_text(spec.to_xml())
    return path


def test_an_mjcf_file_loads_as_the_robot_of_its_urdf(tmp_path):
    urdf = wbc.load(SIMPLE, **FEET)
    mjcf = wbc.load(mjcf_of_simple_humanoid(tmp_path / "robot.xml"), **FEET)
    assert mjcf.joint_names == urdf.joint_names
    assert [sole.size_text for sole in mjcf.soles] == [sole.size_text for sole in urdf.soles]
    np.testing.assert_allclose(mjcf.q_min, urdf.q_min, atol=1e-6)
    np.testing.assert_allclose(mjcf.tau_max, urdf.tau_max, rtol=1e-6)
    for robot in (urdf, mjcf):
        assert [f for f in robot.check() if f.severity == "error"] == []
    q = urdf.q_nominal
    M, N = (pin.crba(r.model, r.model.createData(), q) for r in (urdf, mjcf))
    np.testing.assert_allclose(N, M, atol=1e-4 * np.abs(M).max())


def test_a_robot_stands_as_a_keyframe_of_its_mjcf_file_does(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    path = mjcf_of_simple_humanoid(tmp_path / "robot.xml")
    model = mujoco.MjModel.from_xml_path(str(path))
    text = path.read_text()

    def posture(name: str, **joints: float) -> str:
        q = model.qpos0.copy()
        for joint, value in joints.items():
            q[model.joint(joint).qposadr] = value
        return f'<key name="{name}" qpos="{" ".join(map(str, q))}"/>'

    leg = {"hip_pitch": -0.35, "knee": 0.7, "ankle_pitch": -0.35}
    legs = {f"{side}_{name}": x for side in ("left", "right") for name, x in leg.items()}
    keys = posture("lying", left_knee=1.5) + posture("home", **legs, left_elbow=1.0)
    path.write_text(text.replace("</mujoco>", f"<keyframe>{keys}</keyframe></mujoco>"))
    robot = wbc.load(path, **FEET)
    at = dict(zip(robot.joint_names, robot.q_nominal[7:], strict=True))
    assert (at["left_knee"], at["left_elbow"]) == pytest.approx((0.7, 1.0), abs=0.05)
    assert "'home'" in str(robot.facts)
    with pytest.raises(RobotDescriptionError, match="no group_state 'homee'; did you mean 'home'"):
        wbc.load(path, **FEET, group_state="homee")
    # Legs that are straight are no posture to stand in; the arms' is taken.
    keys = posture("home", left_elbow=1.0)
    path.write_text(text.replace("</mujoco>", f"<keyframe>{keys}</keyframe></mujoco>"))
    robot = wbc.load(path, **FEET)
    at = dict(zip(robot.joint_names, robot.q_nominal[7:], strict=True))
    assert (at["left_knee"], at["left_elbow"]) == pytest.approx((0.4, 1.0), abs=0.05)


def test_joints_of_one_body_become_a_chain_with_their_own_limits(tmp_path):
    path = tmp_path / "biped.xml"
    path.write_text(BIPED)
    joints = {joint.name: joint for joint in read_description(path).joints}
    assert [j.type for j in joints.values()] == ["revolute", "revolute", "prismatic"]
    assert joints["left_hip_pitch"].child == "left_thigh"
    assert joints["left_hip_roll"].child == joints["left_hip_pitch"].parent
    efforts = [float(j.element.find("limit").get("effort")) for j in joints.values()]
    assert efforts == [50.0, 60.0, 0.0]


def test_a_ball_joint_is_refused_with_its_name(tmp_path):
    path = tmp_path / "ball.xml"
    ball = BIPED.replace(
        'name="left_ankle" type="slide" axis="0 0 1" range="0 .2"', 'name="b" type="ball"'
    )
    path.write_text(ball)
    with pytest.raises(RobotDescriptionError, match=r"'b' has 3 degrees of freedom"):
        read_description(path)


def test_xacro_is_expanded(tmp_path):
    pytest.importorskip("xacro")
    text = SIMPLE.read_text().replace(
        "<robot ", '<robot xmlns:xacro="http://ros.org/wiki/xacro" ', 1
    )
    head, tag, rest = text.partition("<link ")
    effort = '<xacro:property name="strength" value="${2 * 100}"/>'
    path = tmp_path / "robot.urdf.xacro"
    path.write_text(head + effort + tag + rest.replace('effort="200"', 'effort="${strength}"'))
    robot = wbc.load(path, **FEET)
    np.testing.assert_allclose(robot.tau_max, wbc.load(SIMPLE, **FEET).tau_max)
    path.write_text(text.replace('mass value="', 'mass value="${nothing}', 1))
    with pytest.raises(RobotDescriptionError, match=r"xacro cannot expand it .*nothing"):
        wbc.load(path, **FEET)


def test_without_xacro_the_error_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "xacro", None)
    path = tmp_path / "robot.xacro"
    path.write_text(SIMPLE.read_text())
    with pytest.raises(MissingExtra, match=r"wbc\[xacro\]"):
        wbc.load(path)


def test_names_of_robot_descriptions_are_found(monkeypatch):
    module = types.ModuleType("robot_descriptions.butler_description")
    module.URDF_PATH = str(SIMPLE)
    monkeypatch.setitem(sys.modules, "robot_descriptions", types.ModuleType("robot_descriptions"))
    monkeypatch.setitem(sys.modules, module.__name__, module)
    robot = wbc.load("butler_description", **FEET)
    assert (robot.name, robot.urdf_path) == ("butler", SIMPLE)
    with pytest.raises(RobotNotFound):
        wbc.load("valet_description")

"""Joints that one motor moves together: read from `<mimic>`, kept by controller and plant."""

from __future__ import annotations

import numpy as np
import pytest
from robottools import SIMPLE, changed

import wbc
from wbc.errors import RobotDescriptionError
from wbc.robot import Coupling
from wbc.sim import Mujoco

AXIS = '<child link="{}"/><origin xyz="{}"/>'
HEAD = '<child link="head"/>'


def coupled(folder, mimic='<mimic joint="torso_yaw" multiplier="-0.5" offset="0.1"/>'):
    return changed(folder, (HEAD, HEAD + mimic))


def test_a_mimic_is_a_coupling_and_the_nominal_posture_keeps_it(tmp_path):
    robot = wbc.load(coupled(tmp_path))
    neck, torso = robot.joint_index("neck"), robot.joint_index("torso_yaw")
    assert robot.couplings == (Coupling(neck, torso, -0.5, 0.1),)
    assert robot.q_nominal[7 + neck] == pytest.approx(0.1 - 0.5 * robot.q_nominal[7 + torso])


def test_coupled_joints_share_the_torque_of_their_motor(tmp_path):
    robot, free = wbc.load(coupled(tmp_path)), wbc.load(SIMPLE)
    neck, torso = robot.joint_index("neck"), robot.joint_index("torso_yaw")
    motor = free.tau_max[torso]
    assert robot.tau_max[torso] + 0.5 * robot.tau_max[neck] == pytest.approx(motor)


@pytest.mark.parametrize(
    ("mimic", "complaint"),
    [
        ('<mimic joint="waist"/>', "'neck' mimics 'waist', which the file does not have"),
        ('<mimic joint="neck"/>', "'neck' mimics 'neck', which follows it in turn"),
    ],
)
def test_a_mimic_without_a_leader_is_refused_with_the_joint(tmp_path, mimic, complaint):
    with pytest.raises(RobotDescriptionError, match=complaint):
        wbc.load(coupled(tmp_path, mimic))


def test_coupled_knees_bend_together(tmp_path):
    leader = '<child link="right_shin"/>'
    robot = wbc.load(changed(tmp_path, (leader, leader + '<mimic joint="left_knee"/>')))
    left, right = (robot.q_nominal[7 + robot.joint_index(f"{s}_knee")] for s in ("left", "right"))
    assert left == pytest.approx(right, abs=1e-9)
    assert left > 0.3


def test_a_controller_keeps_joints_coupled_in_closed_loop(tmp_path):
    robot = wbc.load(coupled(tmp_path))
    neck, torso = robot.joint_index("neck"), robot.joint_index("torso_yaw")
    controller = wbc.WholeBodyController(robot)
    controller.add(wbc.ComTask(np.array([0.0, 0.0, robot.com_height]), weight=100.0))
    posture = controller.add(wbc.PostureTask(robot, weight=1.0))
    posture.target[torso] += 0.2
    controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
    errors = []
    with Mujoco(robot) as plant:
        for _ in range(100):
            state = plant.ground_truth()
            command = controller.step(state)
            plant.step(command)
            errors.append(state.q[7 + neck] + 0.5 * state.q[7 + torso] - 0.1)
            assert command.status is wbc.Status.OK
    assert abs(state.q[7 + torso]) > 0.05
    assert max(map(abs, errors)) < 1e-3

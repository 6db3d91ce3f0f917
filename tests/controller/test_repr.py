"""What a person sees in a notebook: names, weights, targets and units in one line."""

import numpy as np
import pinocchio as pin
import pytest
from coretools import controller, robot

import wbc


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (
            lambda r: wbc.ComTask((0.1, 0.0, 0.87)),
            "ComTask('com', weight 100, kp 30 1/s², kd 10.95 1/s, target (0.1, 0, 0.87) m)",
        ),
        (
            lambda r: wbc.FrameTask(
                r.torso, pin.SE3(pin.rpy.rpyToMatrix(0, 0, np.pi / 2), np.ones(3)), priority=0
            ),
            "FrameTask('torso_2_link pose', exact, kp 100 1/s², kd 20 1/s, "
            "target (1, 1, 1) m, roll pitch yaw (0, 0, 90) °)",
        ),
        (
            lambda r: wbc.PositionTask(r.torso, weight=(1.0, 2.0, 3.0)),
            "PositionTask('torso_2_link position', weight 1 to 3, kp 100 1/s², kd 20 1/s, "
            "target held where first evaluated)",
        ),
        (
            lambda r: wbc.PointContact("left_sole", motion_weight=50.0, max_force=300.0),
            "PointContact('left_sole', friction 0.7, weight 50, 0 to 300 N)",
        ),
        (lambda r: wbc.TorqueLimit(r, 100.0), "TorqueLimit(100 N·m)"),
        (lambda r: wbc.JointVelocityLimit(r, 2.0), "JointVelocityLimit(2 rad/s, horizon 0.02 s)"),
        (
            lambda r: wbc.JointPositionLimit(r),
            "JointPositionLimit(margin 0.02 rad, horizon 0.01 s)",
        ),
        (lambda r: wbc.JointAccelerationLimit(r), "JointAccelerationLimit(500 rad/s²)"),
        (
            lambda r: wbc.State(np.r_[0.0, 0.1, 1.0, 0, 0, 0, 1, 0.3], np.r_[np.zeros(6), -0.2]),
            "State(base at (0, 0.1, 1) m, 1 joints, the fastest at 0.2 rad/s)",
        ),
        (
            lambda r: controller(r, "left"),
            "WholeBodyController('talos', dt 0.002 s, tasks: com, torso_2_link orientation, "
            "angular momentum, posture; contacts: left_sole)",
        ),
    ],
)
def test_repr_states_the_main_values_with_units(make, text):
    assert repr(make(robot("talos"))) == text


def test_a_command_shows_its_status_and_what_the_feet_carry():
    bot = robot("talos")
    text = repr(controller(bot, "both").step(bot.standing()))
    assert text.startswith("Command(ok, largest torque ")
    assert "left_sole 4" in text
    assert text.endswith(" N)")

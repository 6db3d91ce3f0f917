"""Checks of a standing posture: torques, height and tilt of the pelvis, size of the support."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.robot import Robot
from wbc.robot.statics import holding_torques

#: Share of any torque limit that a plan may take at rest; the rest moves and balances.
MAX_TORQUE_SHARE = 0.85
MAX_PELVIS_TILT = 0.7  #: rad; 0.9 counts as a fall
_MIN_HEIGHT = 0.65  # share of the pelvis' height when standing; 0.6 counts as a fall
_SAMPLES = 9  # postures that are checked along a path


@dataclass(frozen=True, slots=True)
class HoldingEffort:
    """Joint torques that hold a posture at rest.

    Attributes:
        torque: (na,) joint torques, N·m.
        ratio: the largest |τ| / τ_max.
        joint: name of the joint that has it.
    """

    torque: np.ndarray
    ratio: float
    joint: str


def holding_effort(robot: Robot, q: np.ndarray, weight_shift: float = 0.5) -> HoldingEffort:
    """Return the torques that hold a posture on the soles; see `holding_torques`.

    Args:
        robot: the robot.
        q: (nq,) posture with both soles on the ground.
        weight_shift: 0 when the right foot alone carries, 1 for the left one, else both do.
    """
    left, right = robot.soles
    carrying = {0.0: (right,), 1.0: (left,)}.get(weight_shift, (left, right))
    torque = holding_torques(robot.model, q, [sole.frame_id for sole in carrying])
    ratios = np.abs(torque) / robot.tau_max
    worst = int(np.argmax(ratios))
    return HoldingEffort(torque, float(ratios[worst]), robot.joint_names[worst])


def max_effort_along(robot: Robot, start: np.ndarray, end: np.ndarray) -> HoldingEffort:
    """Return the largest holding effort on the straight path between two postures, (nq,) each."""
    shares = np.linspace(0.0, 1.0, _SAMPLES)
    efforts = [holding_effort(robot, pin.interpolate(robot.model, start, end, s)) for s in shares]
    return max(efforts, key=lambda effort: effort.ratio)


def pelvis_violation(robot: Robot, q: np.ndarray) -> str:
    """Return why the pelvis' height or tilt nearly counts as a fall; empty if it does not.

    Args:
        robot: the robot.
        q: (nq,) posture with both soles on the ground.
    """
    upright = pin.Quaternion(robot.q_nominal[3:7]).toRotationMatrix()
    up = (pin.Quaternion(q[3:7]).toRotationMatrix() @ upright.T)[2, 2]
    tilt = math.acos(min(max(float(up), -1.0), 1.0))
    if tilt > MAX_PELVIS_TILT:
        return (
            f"the pelvis would tilt by {math.degrees(tilt):.0f}° (at most "
            f"{math.degrees(MAX_PELVIS_TILT):.0f}°)"
        )
    share = float(q[2] / robot.q_nominal[2])
    if share < _MIN_HEIGHT:
        return (
            f"the pelvis would be at {100.0 * share:.0f} % of its height when standing (at least "
            f"{100.0 * _MIN_HEIGHT:.0f} %)"
        )
    return ""


def support_half_size(robot: Robot) -> np.ndarray:
    """Return half length and half width of the rectangle around both soles, (2,) m."""
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, robot.q_nominal)
    left, right = (data.oMf[sole.frame_id].translation for sole in robot.soles)
    half_length = min(sole.half_length for sole in robot.soles)
    half_width = min(sole.half_width for sole in robot.soles)
    return np.array([half_length, 0.5 * abs(float(left[1] - right[1])) + half_width])

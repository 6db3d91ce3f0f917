"""What standing allows: joint torques at rest, where the ZMP may be, how low the pelvis may be."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.robot import Robot

#: Share of any torque limit that a plan may take at rest; the rest moves and balances.
STRENGTH = 0.85
_LEVER = 0.1  # m: makes moments comparable to forces
MOST_TILT = 0.7  #: rad of the pelvis; 0.9 count as a fall
_LEAST_HEIGHT = 0.65  # share of the pelvis' height when standing; 0.6 count as a fall
_ON_THE_WAY = 9  # postures that are looked at between two


@dataclass(frozen=True, slots=True)
class HoldingEffort:
    """What a posture asks of the joints.

    Attributes:
        torque: (na,) N·m.
        ratio: largest |τ| / τ_max.
        joint: whose that is.
    """

    torque: np.ndarray
    ratio: float
    joint: str


def holding_effort(robot: Robot, q: np.ndarray, lean: float = 0.5) -> HoldingEffort:
    """Torques that hold a posture on the soles, at rest.

    The smallest wrenches under the soles that carry the weight, then
    `τ = g(q) − Jᵀ f` (moments count by a lever of 0.1 m).

    Args:
        robot: the robot.
        q: (nq,) with both soles on the ground.
        lean: 0 when the right foot alone carries, 1 the left, else both.
    """
    model, data = robot.model, robot.model.createData()
    gravity = pin.computeGeneralizedGravity(model, data, q)
    pin.computeJointJacobians(model, data, q)
    left, right = robot.soles
    carrying = {0.0: (right,), 1.0: (left,)}.get(lean, (left, right))
    J = np.vstack(
        [pin.computeFrameJacobian(model, data, q, s.frame_id, pin.LOCAL) for s in carrying]
    )
    scale = np.tile([1.0, 1.0, 1.0, _LEVER, _LEVER, _LEVER], len(carrying))
    wrenches = scale * np.linalg.lstsq(J[:, :6].T * scale, gravity[:6], rcond=None)[0]
    torque = gravity[6:] - J[:, 6:].T @ wrenches
    ratios = np.abs(torque) / robot.tau_max
    worst = int(np.argmax(ratios))
    return HoldingEffort(torque, float(ratios[worst]), robot.joint_names[worst])


def max_effort_along(robot: Robot, start: np.ndarray, end: np.ndarray) -> HoldingEffort:
    """The largest effort, at rest, on the straight way between two postures (nq,) each."""
    ways = np.linspace(0.0, 1.0, _ON_THE_WAY)
    efforts = [holding_effort(robot, pin.interpolate(robot.model, start, end, s)) for s in ways]
    return max(efforts, key=lambda one: one.ratio)


def pelvis_violation(robot: Robot, q: np.ndarray) -> str:
    """What makes a posture one that nearly counts as a fall; empty when nothing does.

    Args:
        robot: the robot.
        q: (nq,) with both soles on the ground.
    """
    upright = pin.Quaternion(robot.q_nominal[3:7]).toRotationMatrix()
    up = (pin.Quaternion(q[3:7]).toRotationMatrix() @ upright.T)[2, 2]
    tilt = math.acos(min(max(float(up), -1.0), 1.0))
    if tilt > MOST_TILT:
        return (
            f"the pelvis would tilt by {math.degrees(tilt):.0f}° (at most "
            f"{math.degrees(MOST_TILT):.0f}°)"
        )
    share = float(q[2] / robot.q_nominal[2])
    if share < _LEAST_HEIGHT:
        return (
            f"the pelvis would be at {100.0 * share:.0f} % of its height when standing (at least "
            f"{100.0 * _LEAST_HEIGHT:.0f} %)"
        )
    return ""


def support_half_size(robot: Robot) -> np.ndarray:
    """(2,) half length and half width of the rectangle around both soles when standing, m."""
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, robot.q_nominal)
    left, right = (data.oMf[sole.frame_id].translation for sole in robot.soles)
    half_length = min(sole.half_length for sole in robot.soles)
    half_width = min(sole.half_width for sole in robot.soles)
    return np.array([half_length, 0.5 * abs(float(left[1] - right[1])) + half_width])

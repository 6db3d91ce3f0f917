"""Orientation, heading and height of the body, independent of the axes of its base link."""

from __future__ import annotations

import math

import pinocchio as pin

from wbc.geometry.planar import quaternion_yaw
from wbc.robot import Robot
from wbc.state import State


def attitude(robot: Robot, state: State) -> tuple[float, float, float, float]:
    """Return the unit quaternion (x, y, z, w) of the body; identity when it stands heading +x.

    It is the orientation of the base times the inverse of the nominal one, because some models
    have a base link whose x axis points backward or whose z axis is horizontal.
    """
    x, y, z, w = state.q[3:7].tolist()
    a, b, c, d = robot.q_nominal[3:7].tolist()
    # (x, y, z, w) ⊗ (−a, −b, −c, d)
    return (
        d * x - w * a - y * c + z * b,
        d * y - w * b - z * a + x * c,
        d * z - w * c - x * b + y * a,
        w * d + x * a + y * b + z * c,
    )


def tilt(robot: Robot, state: State) -> tuple[float, float]:
    """Return the angle from the vertical of what is vertical when the robot stands, and its rate.

    Radians and rad/s; a rate towards the vertical is negative.
    """
    up = pin.Quaternion(robot.q_nominal[3:7]).matrix()[2]
    vertical = pin.Quaternion(state.q[3:7]).matrix()[2]
    (a, b, c), (x, y, z), (p, q, r) = up.tolist(), vertical.tolist(), state.v[3:6].tolist()
    cosine = min(max(a * x + b * y + c * z, -1.0), 1.0)
    # The world's vertical u in base axes turns as u̇ = u × ω; the body's own is constant there.
    derivative = a * (y * r - z * q) + b * (z * p - x * r) + c * (x * q - y * p)
    # Upright, the tilt has no direction yet: its rate is zero there and grows with it.
    return math.acos(cosine), -derivative / max(math.sqrt(1.0 - cosine * cosine), 1e-3)


def base_height(state: State) -> tuple[float, float]:
    """Return the world height of the base, m, and its vertical velocity, m/s."""
    x, y, z, w = state.q[3:7].tolist()
    u, v, n = state.v[:3].tolist()
    rate = 2.0 * ((x * z - w * y) * u + (y * z + w * x) * v) + (1.0 - 2.0 * (x * x + y * y)) * n
    return float(state.q[2]), rate


def heading(robot: Robot, state: State) -> float:
    """Return the heading of the body about world z, rad; 0 when it stands."""
    return quaternion_yaw(*attitude(robot, state))

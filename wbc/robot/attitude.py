"""Orientation and heading of the body, independent of the axes of its base link."""

from __future__ import annotations

import math

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


def heading(robot: Robot, state: State) -> float:
    """Return the heading of the body about world z, rad; 0 when it stands."""
    x, y, z, w = attitude(robot, state)
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))

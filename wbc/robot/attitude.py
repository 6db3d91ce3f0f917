"""How the body is turned, whatever way its base link's axes point."""

from __future__ import annotations

import math

from wbc.robot import Robot
from wbc.state import State


def attitude(robot: Robot, state: State) -> tuple[float, float, float, float]:
    """Unit quaternion (x, y, z, w) of the body: the identity when standing, heading +x.

    The base's orientation times the inverse of the nominal one: some models have a base
    link whose x axis points backward or whose z axis lies flat.
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
    """Heading of the body about world z, rad; 0 when standing."""
    x, y, z, w = attitude(robot, state)
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))

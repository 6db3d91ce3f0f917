"""The criterion of a fall."""

from __future__ import annotations

import math

from wbc.robot import Robot
from wbc.robot.attitude import attitude
from wbc.state import State

#: Tilt beyond which a robot has fallen, rad, and the share of the base's height when standing below
#: which it has. Robots recover from more than they seem to: after 6 of 240 blows of 400 to 500 N
#: on arms and ankles, a walking G1 did from tilts of 50° to 69°.
MAX_TILT, LEAST_HEIGHT = math.radians(70.0), 0.6


def fall_reason(robot: Robot, state: State, ground: float = 0.0) -> str:
    """Return why the robot counts as fallen; an empty text if it stands.

    It has fallen when its base tilts by more than 70° or is lower than 60 % of its height
    when standing.

    Args:
        robot: the robot.
        state: its true state.
        ground: height of the ground, m.
    """
    q = state.q
    x, y, _, _ = attitude(robot, state)
    up = 1.0 - 2.0 * (x * x + y * y)  # cosine of the tilt
    if up < math.cos(MAX_TILT):
        return f"the base is tilted by {math.degrees(math.acos(max(up, -1.0))):.0f}°"
    height = float(q[2]) - ground
    if height < LEAST_HEIGHT * float(robot.q_nominal[2]):
        return f"the base is only {height:.2f} m above the ground"
    return ""

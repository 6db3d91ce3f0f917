"""Walks to a place that was clicked on the floor."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wbc.errors import short_repr
from wbc.gait import VelocityLimits
from wbc.geometry.planar import Placement
from wbc.robot.attitude import heading
from wbc.state import State
from wbc.teleop import CommandRefused
from wbc.teleop.number_checks import check_number
from wbc.walking import WaypointFollower

if TYPE_CHECKING:
    from wbc.robot import Robot

_FAR = 1e3  # m, from the origin
_SPEED = 0.7  # share of the largest velocities
_GAIN = 0.6  # 1/s
_NEAR = 0.8  # m, within which the robot steps in any direction
_PERIOD = 0.1  # s between two commands


class WalkTo:
    """Turns a place on the floor into velocity commands, until the robot is there.

    Args:
        robot: The robot.
        limits: Velocities that may be commanded.

    Attributes:
        target: Position, m, and heading, rad or None for any; None while there is no target.
    """

    def __init__(self, robot: Robot, limits: VelocityLimits) -> None:
        self._robot, self._limits = robot, limits.scaled(_SPEED)
        self._follower = WaypointFollower(self._limits)
        self._next = -math.inf
        self.target: tuple[float, float, float | None] | None = None

    def start(self, value: Any) -> None:
        """Walk to `[x, y, heading or null]`, m and rad, world axes.

        Raises:
            CommandRefused: The request has another form, or a heading and the robot cannot turn.
        """
        if not isinstance(value, list) or len(value) != 3:
            raise CommandRefused(
                f"walk_to is {short_repr(value)}; it is [x, y, heading or null], m and rad"
            )
        x, y = (check_number("walk_to", place, -_FAR, _FAR, "m") for place in value[:2])
        yaw = value[2]
        if yaw is not None:
            yaw = check_number("heading", yaw, -_FAR, _FAR, "rad")
            if not self._limits.turn:
                raise CommandRefused(
                    f"'{self._robot.name}' cannot turn (at most 0 rad/s), and the place has a "
                    f"heading of {yaw:.2f} rad; leave the heading out (null)"
                )
        self.target = (x, y, yaw)
        self._next = -math.inf
        self._follower = WaypointFollower(self._limits, (_GAIN, _GAIN, _GAIN), _NEAR)

    def velocity(self, tick: Any) -> tuple[float, float, float] | None:
        """Return the velocity to command next; None if none is due.

        It is zero once, when the robot is there; then there is no target any more.

        Args:
            tick: The last record of the ticks.
        """
        time = float(tick["time"])
        if self.target is None or self._next - 10.0 * _PERIOD < time < self._next:
            return None
        self._next = time + _PERIOD
        q = tick["q"]
        pose = Placement(complex(q[0], q[1]), heading(self._robot, State(q, tick["v"])))
        x, y, yaw = self.target
        waypoint = Placement(complex(x, y), pose.yaw if yaw is None else yaw)
        velocity = self._follower.velocity(waypoint, pose)
        if self._follower.position_reached and (yaw is None or self._follower.yaw_reached):
            self.target = None
            return (0.0, 0.0, 0.0)
        return velocity

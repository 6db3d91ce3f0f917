"""Walks to a given place: from the error of the pose to a velocity command."""

from __future__ import annotations

import math

from wbc.geometry.planar import Placement


class WaypointFollower:
    """Turns the way that is left to a waypoint into a velocity command.

    The command is proportional to the error, in the robot's heading frame,

        (v_x, v_y) = k_p R(−yaw) (p* − p),    ω = k_yaw (yaw* − yaw),

    and zero once the error is below `reached`; it comes back only when the error is above `left`,
    so that the sway of a walk on the spot starts no step. A command beyond the limits is scaled
    down to them, so that its direction stays.

    Args:
        limits: largest forward and sideways velocity, m/s, and turn, rad/s.
        position_gain: k_p, 1/s.
        yaw_gain: k_yaw, 1/s.
        reached: distance, m, and angle, rad, below which place and heading are reached.
        left: distance, m, and angle, rad, above which they count as left again.

    Attributes:
        position_reached: whether the place is reached.
        yaw_reached: whether the heading is reached.
    """

    def __init__(
        self,
        limits: tuple[float, float, float] = (math.inf, math.inf, math.inf),
        position_gain: float = 1.5,
        yaw_gain: float = 1.5,
        reached: tuple[float, float] = (0.1, 0.05),
        left: tuple[float, float] = (0.2, 0.12),
    ) -> None:
        self._limits = limits
        self._gain, self._yaw_gain = position_gain, yaw_gain
        self._reached, self._left = reached, left
        self.position_reached = self.yaw_reached = False

    def velocity(self, waypoint: Placement, pose: Placement) -> tuple[float, float, float]:
        """Return the velocity to command: forward and left, m/s, and turn to the left, rad/s.

        Args:
            waypoint: where to go, in any frame on the ground.
            pose: where the robot is and what it faces, in the same frame.
        """
        error = waypoint.relative_to(pose)
        distance = (self._left if self.position_reached else self._reached)[0]
        angle = (self._left if self.yaw_reached else self._reached)[1]
        self.position_reached = abs(error.point) < distance
        self.yaw_reached = abs(error.yaw) < angle
        way = 0j if self.position_reached else self._gain * error.point
        turn = 0.0 if self.yaw_reached else self._yaw_gain * error.yaw
        wanted = (way.real, way.imag, turn)
        beyond = max(abs(v) / limit for v, limit in zip(wanted, self._limits, strict=True))
        forward, left, turn = (v / max(beyond, 1.0) for v in wanted)
        return forward, left, turn

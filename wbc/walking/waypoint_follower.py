"""Walks to a given place: from the error of the pose to a velocity command."""

from __future__ import annotations

import cmath
import math

from wbc.gait import GaitParameters, VelocityLimits
from wbc.geometry.planar import Placement

_UNLIMITED = VelocityLimits()
_TURN_LENGTH = 0.2  # m of path that one radian of turning counts as
_MAX_BEARING = 1.0  # rad beside which a far waypoint is turned to before walking
_ABOUT = 2.5  # rad beyond which a turn goes on in the direction in which it began
_STEP = 0.1  # s, of the prediction
_MAX_TIME = 600.0  # s
_PER_STEP = 0.8  # share of the remaining way that one step makes
_PLACE_REACHED = 0.015, 0.02  # m, rad: about what a foot is off the place where it was to land


class WaypointFollower:
    """Turns the way that is left to a waypoint into a velocity command.

    Near a waypoint the command is proportional to the error, in the robot's heading frame,

        (v_x, v_y) = (k_x, k_y) ∘ R(−yaw) (p* − p),    ω = k_yaw (yaw* − yaw),

    and zero once the error is below `reached`; it comes back only when the error is above `left`,
    so that the sway of a walk on the spot starts no step. A robot that is farther than `near` turns
    to the waypoint and walks forward, unless it cannot turn. A command beyond the limits is scaled
    into them, so that its direction stays.

    Args:
        limits: velocities that may be commanded.
        gains: k_x, k_y, k_yaw, 1/s. A velocity takes effect with the next step, so a gain above
            about one over twice the duration of a step overshoots, unless the robot's place is its
            `Walker.stopping_place`.
        near: distance within which the robot steps in any direction, m.
        reached: distance, m, and angle, rad, below which place and heading are reached.
        left: distance, m, and angle, rad, above which they count as left again.

    Attributes:
        position_reached: whether the place is reached.
        yaw_reached: whether the heading is reached.
    """

    def __init__(
        self,
        limits: VelocityLimits = _UNLIMITED,
        gains: tuple[float, float, float] = (1.5, 1.5, 1.5),
        near: float = math.inf,
        reached: tuple[float, float] = (0.1, 0.05),
        left: tuple[float, float] = (0.2, 0.12),
    ) -> None:
        self._limits, self._near = limits, near
        self._gains = gains
        self._reached, self._left = reached, left
        self._turn = 0.0  # rad, the last one
        self.position_reached = self.yaw_reached = False

    @classmethod
    def for_gait(cls, gait: GaitParameters, share: float = 1.0) -> WaypointFollower:
        """Return a follower that stops exactly, for a robot whose place is its `stopping_place`.

        The velocity is that of the one step that leads there; sideways and turning, only every
        other step makes way, so that a step has twice the velocity.

        Args:
            gait: parameters of the gait.
            share: of the largest velocities that may be commanded.
        """
        rate = _PER_STEP / gait.step_duration
        return cls(
            gait.max_velocity.scaled(share),
            (rate, 0.5 * rate, 0.5 * rate),
            reached=_PLACE_REACHED,
            left=(2.0 * _PLACE_REACHED[0], 2.0 * _PLACE_REACHED[1]),
        )

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
        way = 0j if self.position_reached else error.point
        turn = 0.0 if self.yaw_reached else error.yaw
        if abs(way) > self._near and self._limits.turn:
            turn = cmath.phase(way)
            way = complex(math.cos(turn) ** 2 * abs(way) if abs(turn) < _MAX_BEARING else 0.0)
        if abs(turn) > _ABOUT and turn * self._turn < 0.0:  # half a turn away, noise would decide
            turn += math.copysign(math.tau, self._turn)
        self._turn = turn
        ahead, beside, yaw = self._gains
        return self._limits.clamp(ahead * way.real, beside * way.imag, yaw * turn)

    def remaining(self, waypoint: Placement, pose: Placement) -> float:
        """Return the remaining path, m: the distance, and 0.2 m per radian of turning."""
        error = waypoint.relative_to(pose)
        distance = abs(error.point)
        turn = cmath.phase(error.point) if distance > self._near else error.yaw
        return distance + _TURN_LENGTH * abs(turn)

    def time_left(self, waypoint: Placement, pose: Placement) -> float:
        """Return the time in which a robot that obeys at once reaches the waypoint, s.

        The command is followed until both are reached, at most ten minutes.
        """
        follower = WaypointFollower(
            self._limits, self._gains, self._near, self._reached, self._left
        )
        time = 0.0
        while time < _MAX_TIME:
            forward, left, turn = follower.velocity(waypoint, pose)
            if follower.position_reached and follower.yaw_reached:
                break
            pose = pose.compose(Placement(_STEP * complex(forward, left), _STEP * turn))
            time += _STEP
        return time

"""How to walk to a pose: from where the robot is, a velocity for its gait."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wbc.geometry.planar import wrap_angle

Velocity = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Pose:
    """A place on the ground and a heading: m, m, rad."""

    x: float
    y: float
    heading: float

    def seen_from(self, other: Pose) -> Pose:
        """This pose in another one's axes."""
        dx, dy = self.x - other.x, self.y - other.y
        c, s = math.cos(other.heading), math.sin(other.heading)
        return Pose(c * dx + s * dy, c * dy - s * dx, wrap_angle(self.heading - other.heading))

    def from_within(self, other: Pose) -> Pose:
        """This pose, given in another one's axes, in that one's world."""
        c, s = math.cos(other.heading), math.sin(other.heading)
        return Pose(
            other.x + c * self.x - s * self.y,
            other.y + s * self.x + c * self.y,
            wrap_angle(other.heading + self.heading),
        )

    @property
    def distance(self) -> float:
        """From the origin, m."""
        return math.hypot(self.x, self.y)


@dataclass(frozen=True, slots=True)
class Approach:
    """From afar turn to the goal and walk forward; near it, step to it in any direction.

    Attributes:
        max_velocity: forward, left (m/s) and turn (rad/s) that may be used, one at a time.
        near: distance below which it walks in any direction, m.
        gain: 1/s; at most about one over twice a step's duration, or it overshoots: a velocity
            takes effect with the next step.
    """

    max_velocity: Velocity
    near: float
    gain: float

    def left(self, error: Pose) -> float:
        """How much is left to do, m: the way, and a turn of 1 rad counting as 0.2 m."""
        far = error.distance > self.near
        turn = math.atan2(error.y, error.x) if far else error.heading
        return error.distance + 0.2 * abs(turn)

    def velocity(self, error: Pose) -> Velocity:
        """The velocity to walk at.

        Args:
            error: the goal, seen from the robot.
        """
        if error.distance <= self.near:
            wanted = (self.gain * error.x, self.gain * error.y, self.gain * error.heading)
        else:
            bearing = math.atan2(error.y, error.x)
            ahead = math.cos(bearing) ** 2 if abs(bearing) < 1.0 else 0.0
            wanted = (self.gain * error.distance * ahead, 0.0, self.gain * bearing)
        # What a gait can do in one direction it cannot do in all at once.
        effort = sum(abs(v) / most for v, most in zip(wanted, self.max_velocity, strict=True))
        x, y, turn = (v / max(1.0, effort) for v in wanted)
        return (x, y, turn)

"""How to walk to a pose: from where the robot is, a velocity for its gait."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wbc.gait.planar import wrap

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
        return Pose(c * dx + s * dy, c * dy - s * dx, wrap(self.heading - other.heading))

    def from_within(self, other: Pose) -> Pose:
        """This pose, given in another one's axes, in that one's world."""
        c, s = math.cos(other.heading), math.sin(other.heading)
        return Pose(
            other.x + c * self.x - s * self.y,
            other.y + s * self.x + c * self.y,
            wrap(other.heading + self.heading),
        )

    @property
    def distance(self) -> float:
        """From the origin, m."""
        return math.hypot(self.x, self.y)


@dataclass(frozen=True, slots=True)
class Approach:
    """From afar turn to the goal and walk forward; near it, step to it in any direction.

    Attributes:
        max_velocity: forward, left (m/s) and turn (rad/s) that may be used.
        near: distance below which it walks in any direction, m.
        gain: 1/s; at most about one over twice a step's duration, or it overshoots: a velocity
            takes effect with the next step.
    """

    max_velocity: Velocity
    near: float
    gain: float

    def velocity(self, error: Pose) -> Velocity:
        """The velocity to walk at.

        Args:
            error: the goal, seen from the robot.
        """
        forward, left, turn = self.max_velocity
        if error.distance <= self.near:
            return (
                _clamp(self.gain * error.x, forward),
                _clamp(self.gain * error.y, left),
                _clamp(self.gain * error.heading, turn),
            )
        bearing = math.atan2(error.y, error.x)
        speed = min(forward, self.gain * error.distance) * max(0.0, math.cos(bearing)) ** 2
        return (speed if abs(bearing) < 1.0 else 0.0, 0.0, _clamp(self.gain * bearing, turn))


def _clamp(value: float, most: float) -> float:
    return max(-most, min(most, value))

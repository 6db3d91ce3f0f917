"""Feedback from the error of the robot's planar pose to a velocity of its gait."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wbc.geometry.planar import wrap_angle

Velocity = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class PlanarPose:
    """A position on the ground and a heading.

    Attributes:
        x: m.
        y: m.
        heading: about the vertical, rad.
    """

    x: float
    y: float
    heading: float

    def relative_to(self, other: PlanarPose) -> PlanarPose:
        """Return this pose in the axes of another one."""
        dx, dy = self.x - other.x, self.y - other.y
        c, s = math.cos(other.heading), math.sin(other.heading)
        return PlanarPose(
            c * dx + s * dy, c * dy - s * dx, wrap_angle(self.heading - other.heading)
        )

    def in_world_of(self, other: PlanarPose) -> PlanarPose:
        """Return this pose, which is given in the axes of another one, in that one's world."""
        c, s = math.cos(other.heading), math.sin(other.heading)
        return PlanarPose(
            other.x + c * self.x - s * self.y,
            other.y + s * self.x + c * self.y,
            wrap_angle(other.heading + self.heading),
        )

    @property
    def distance(self) -> float:
        """Distance from the origin, m."""
        return math.hypot(self.x, self.y)


@dataclass(frozen=True, slots=True)
class PoseController:
    """From afar it turns to the goal and walks forward; near the goal it steps in any direction.

    Attributes:
        max_velocity: largest forward, left (m/s) and turn (rad/s), one at a time.
        near: distance below which it steps in any direction, m.
        gain: 1/s; at most about one over twice a step's duration, or it overshoots: a velocity
            takes effect with the next step.
    """

    max_velocity: Velocity
    near: float
    gain: float

    def remaining(self, error: PlanarPose) -> float:
        """Return what is left to do, m: the distance, and 0.2 m per radian of turning."""
        far = error.distance > self.near
        turn = math.atan2(error.y, error.x) if far else error.heading
        return error.distance + 0.2 * abs(turn)

    def velocity(self, error: PlanarPose) -> Velocity:
        """Return the velocity to walk at: forward, left (m/s) and turn (rad/s).

        Args:
            error: pose of the goal in the axes of the robot.
        """
        if error.distance <= self.near:
            wanted = (self.gain * error.x, self.gain * error.y, self.gain * error.heading)
        else:
            bearing = math.atan2(error.y, error.x)
            ahead = math.cos(bearing) ** 2 if abs(bearing) < 1.0 else 0.0
            wanted = (self.gain * error.distance * ahead, 0.0, self.gain * bearing)
        # A gait reaches its largest velocity in one direction at a time.
        effort = sum(abs(v) / most for v, most in zip(wanted, self.max_velocity, strict=True))
        x, y, turn = (v / max(1.0, effort) for v in wanted)
        return (x, y, turn)

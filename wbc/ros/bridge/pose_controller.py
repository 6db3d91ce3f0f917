"""Feedback from the error of the robot's planar pose to a velocity of its gait."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from wbc.gait import VelocityLimits
from wbc.geometry.planar import Placement


@dataclass(frozen=True, slots=True)
class PoseController:
    """Turns to a far goal and walks forward; steps towards a near goal in any direction.

    Attributes:
        max_velocity: the velocities that the robot may walk at.
        near: distance within which the robot steps in any direction, m.
        gain: 1/s. A velocity takes effect with the next step, so a gain above about one over twice
            the duration of a step overshoots.
    """

    max_velocity: VelocityLimits
    near: float
    gain: float

    def remaining(self, error: Placement) -> float:
        """Return the remaining path, m: the distance, and 0.2 m per radian of turning."""
        distance = abs(error.point)
        turn = cmath.phase(error.point) if distance > self.near else error.yaw
        return distance + 0.2 * abs(turn)

    def velocity(self, error: Placement) -> tuple[float, float, float]:
        """Return the velocity to walk at: forward, left (m/s) and turn (rad/s).

        Args:
            error: pose of the goal in the axes of the robot.
        """
        if abs(error.point) <= self.near:
            desired = (error.point.real, error.point.imag, error.yaw)
        else:
            bearing = cmath.phase(error.point)
            ahead = math.cos(bearing) ** 2 if abs(bearing) < 1.0 else 0.0
            desired = (ahead * abs(error.point), 0.0, bearing)
        return self.max_velocity.clamp(*(self.gain * component for component in desired))

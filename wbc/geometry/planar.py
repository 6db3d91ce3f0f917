"""Planar geometry of the gait: points of the ground as complex numbers.

x + iy in world axes: a sum translates, a product with exp(iθ) turns. The gait's
arithmetic on single points is an order of magnitude cheaper this way than on arrays
of two numbers, and it runs every tick.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


def ground_point(position: np.ndarray) -> complex:
    """The ground point below a position (3,) or (2,)."""
    return complex(float(position[0]), float(position[1]))


def planar_rotation(yaw: float) -> complex:
    """exp(i yaw), the factor that turns a point by yaw, rad."""
    return cmath.rect(1.0, yaw)


def wrap_angle(angle: float) -> float:
    """The same angle in [−π, π)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def yaw_of(rotation: np.ndarray) -> float:
    """Heading of a frame's x axis about world z, rad."""
    return math.atan2(rotation[1, 0], rotation[0, 0])


def quaternion_yaw(x: float, y: float, z: float, w: float) -> float:
    """The same of a unit quaternion, rad."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def rotation_about_z(yaw: float) -> np.ndarray:
    """(3, 3) rotation about the world's z axis by yaw, rad."""
    rotation = np.eye(3)
    set_rotation_about_z(rotation, yaw)
    return rotation


def set_rotation_about_z(rotation: np.ndarray, yaw: float) -> None:
    """Write the rotation by yaw, rad, into a (3, 3) rotation about the world's z axis."""
    c, s = math.cos(yaw), math.sin(yaw)
    rotation[0, 0] = rotation[1, 1] = c
    rotation[1, 0], rotation[0, 1] = s, -s


class Placement(NamedTuple):
    """A pose on the ground: of a sole, or of the robot.

    Attributes:
        point: x + iy of the sole's centre or the robot's base, m.
        yaw: heading, rad.
        height: z, m.
    """

    point: complex
    yaw: float
    height: float = 0.0

    def to_world(self, local: complex) -> complex:
        """World point of a point given in the axes of this placement."""
        return self.point + local * cmath.rect(1.0, self.yaw)

    def to_local(self, world: complex) -> complex:
        """Coordinates of a world point in the axes of this placement."""
        return (world - self.point) * cmath.rect(1.0, -self.yaw)

    def relative_to(self, other: Placement) -> Placement:
        """This placement in the axes of another one."""
        return Placement(
            other.to_local(self.point), wrap_angle(self.yaw - other.yaw), self.height - other.height
        )

    def compose(self, relative: Placement) -> Placement:
        """The world placement of one that is given in this one's axes."""
        point, yaw, height = self
        other, turn, rise = relative
        return Placement(
            point + other * cmath.rect(1.0, yaw), wrap_angle(yaw + turn), height + rise
        )


@dataclass(slots=True)
class Feet:
    """The measured placements of both soles."""

    left: Placement
    right: Placement

    def of(self, side: str) -> Placement:
        """The sole of a side."""
        return self.left if side == "left" else self.right

    @property
    def middle(self) -> complex:
        """Ground point midway between the soles."""
        return 0.5 * (self.left.point + self.right.point)

"""A ramp up to a plateau, and down again."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wbc.errors import PlantError
from wbc.sim.terrain import check_sizes

_THICKNESS = 0.3  # m
_STEEPEST = math.radians(30.0)


@dataclass(frozen=True, slots=True)
class Ramp:
    """A ramp in front of the robot, a plateau behind it, and a ramp down to the floor.

    Attributes:
        angle: slope of both ramps, rad.
        length: length of each ramp along its surface, m.
        plateau: length of the plateau, m.
        width: width across, m.
        distance: from the robot's start to the foot of the ramp, m.

    Raises:
        PlantError: a size that is not positive, or an angle that is not within 30°.
    """

    angle: float = math.radians(10.0)
    length: float = 2.0
    plateau: float = 1.0
    width: float = 4.0
    distance: float = 0.5

    def __post_init__(self) -> None:
        check_sizes(self, "length", "plateau", "width", "distance")
        if not 0.0 < self.angle <= _STEEPEST:
            raise PlantError(f"Ramp: angle is {self.angle} rad, it must be within 0 and 0.52 (30°)")

    def boxes(self) -> np.ndarray:
        """Return centre, half sizes (m), roll and pitch (rad) of ramps and plateau, (3, 8)."""
        half = 0.5 * _THICKNESS
        run, rise = self.length * math.cos(self.angle), self.length * math.sin(self.angle)
        sizes = (0.5 * self.length, 0.5 * self.width, half)
        sunk = half * math.sin(self.angle), half * math.cos(self.angle)
        middle = self.distance + run + 0.5 * self.plateau
        ends = self.distance + 0.5 * run, self.distance + 1.5 * run + self.plateau
        z = 0.5 * rise - sunk[1]
        return np.array(
            [
                [ends[0] + sunk[0], 0.0, z, *sizes, 0.0, -self.angle],
                [middle, 0.0, rise - half, 0.5 * self.plateau, 0.5 * self.width, half, 0.0, 0.0],
                [ends[1] - sunk[0], 0.0, z, *sizes, 0.0, self.angle],
            ]
        )

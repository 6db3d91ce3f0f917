"""Walls and rails: obstacles that a hand can push against."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wbc.errors import PlantError
from wbc.sim.terrain import check_sizes


@dataclass(frozen=True, slots=True)
class Wall:
    """An upright wall in front of the robot or beside it.

    Attributes:
        distance: from the middle of the soles at the start to the wall's face, m.
        towards: side of the robot where it is: "front", "left" or "right".
        height: of its top above the floor, m.
        bottom: of its lower edge above the floor: with feet below it, a rail or a table; m.
        thickness: m.
        width: m.
        friction: Coulomb coefficient.

    Raises:
        PlantError: a size that is not positive, a bottom that is not below the top, or an
            unknown side.
    """

    distance: float = 0.3
    towards: str = "front"
    height: float = 2.0
    bottom: float = 0.0
    thickness: float = 0.1
    width: float = 3.0
    friction: float = 0.8

    def __post_init__(self) -> None:
        check_sizes(self, "distance", "height", "thickness", "width")
        if self.towards not in _SIDES:
            raise PlantError(f"Wall: towards = '{self.towards}' must be one of {', '.join(_SIDES)}")
        if not 0.0 <= self.bottom < self.height:
            raise PlantError(f"Wall: bottom = {self.bottom} m must be in [0, {self.height}) m")
        if not (math.isfinite(self.friction) and self.friction >= 0.0):
            raise PlantError(f"Wall: friction = {self.friction} must be finite and >= 0")

    def boxes(self) -> np.ndarray:
        """Return the wall as one box; see `Terrain`."""
        direction = _SIDES[self.towards]
        middle = (self.distance + 0.5 * self.thickness) * direction
        across = abs(direction.imag), abs(direction.real)
        along = abs(direction.real), abs(direction.imag)
        half = [
            0.5 * (self.thickness * a + self.width * w) for a, w in zip(along, across, strict=True)
        ]
        z, half_height = 0.5 * (self.height + self.bottom), 0.5 * (self.height - self.bottom)
        return np.array([[middle.real, middle.imag, z, *half, half_height]])


_SIDES = {"front": 1.0 + 0.0j, "left": 1.0j, "right": -1.0j}

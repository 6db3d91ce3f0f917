"""A slippery patch on the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wbc.errors import PlantError
from wbc.sim.terrain import check_sizes

_HEIGHT = 1e-3  # m above the floor, so that soles touch the patch alone


@dataclass(frozen=True, slots=True)
class SlipperyPatch:
    """A rectangle in front of the robot with a friction of its own, 1 mm above the floor.

    Attributes:
        friction: Coulomb coefficient between soles and patch.
        distance: from the robot's start to the patch, m.
        length: along the robot's heading, m.
        width: across, m.

    Raises:
        PlantError: a size that is not positive, or negative friction.
    """

    friction: float = 0.3
    distance: float = 0.5
    length: float = 2.0
    width: float = 4.0

    def __post_init__(self) -> None:
        check_sizes(self, "distance", "length", "width")
        if not (math.isfinite(self.friction) and self.friction >= 0.0):
            raise PlantError(f"SlipperyPatch: friction is {self.friction}, it must be at least 0")

    def boxes(self) -> np.ndarray:
        """Return centre and half sizes of the patch, (1, 6), m."""
        thick = 0.05
        middle = self.distance + 0.5 * self.length
        sides = (0.5 * self.length, 0.5 * self.width, thick)
        return np.array([[middle, 0.0, _HEIGHT - thick, *sides]])

"""A staircase up to a landing, and down again."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wbc.errors import PlantError

_DEPTH = 0.1  # m below the floor


@dataclass(frozen=True, slots=True)
class Staircase:
    """Stairs in front of the robot, a landing behind them, and the same stairs down to the floor.

    Attributes:
        risers: height of each stair over the one before it, m.
        tread: depth of each stair, m.
        landing: depth of the landing, on top of the last riser, m.
        width: width across, m.
        distance: from the robot's start to the first riser, m.

    Raises:
        PlantError: a size that is not positive, or no risers.
    """

    risers: tuple[float, ...] = (0.15, 0.15, 0.15)
    tread: float = 0.3
    landing: float = 1.0
    width: float = 2.0
    distance: float = 0.3

    def __post_init__(self) -> None:
        sizes = (self.tread, self.landing, self.width, self.distance, *self.risers)
        if not self.risers or not all(math.isfinite(s) and s > 0.0 for s in sizes):
            raise PlantError(f"{self}: all sizes must be positive (m), and there must be a riser")

    @property
    def tops(self) -> np.ndarray:
        """First and last x and the height of each horizontal face, stairs up to down, (n, 3), m."""
        heights = np.cumsum(self.risers)
        n = len(heights)
        depths = np.array([self.tread] * (n - 1) + [self.landing] + [self.tread] * (n - 1))
        ends = self.distance + np.cumsum(depths)
        return np.column_stack((ends - depths, ends, [*heights, *heights[-2::-1]]))

    def footholds(self, inset: float = 0.16) -> np.ndarray:
        """Return x and height of where both soles' centres stand side by side, (n, 2), m.

        In the middle of each stair, at both ends of a landing that is deeper than one and a half
        stairs, and on the floor behind the last stair.

        Args:
            inset: from the edges of the landing and of the last stair, m.
        """
        places = []
        for begin, end, height in self.tops:
            deep = end - begin > 1.5 * self.tread
            xs = (begin + inset, end - inset) if deep else (0.5 * (begin + end),)
            places += [(x, height) for x in xs]
        return np.array([*places, (self.tops[-1, 1] + inset, 0.0)])

    def boxes(self) -> np.ndarray:
        """Return centre and half sizes of the stairs, (n, 6), m."""
        begin, end, height = self.tops.T
        half = 0.5 * (height + _DEPTH)
        zero, width = np.zeros_like(height), np.full_like(height, 0.5 * self.width)
        middle, depth = 0.5 * (begin + end), 0.5 * (end - begin)
        return np.column_stack((middle, zero, height - half, depth, width, half))

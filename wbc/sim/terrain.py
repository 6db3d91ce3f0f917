"""Terrains: the ground that the simulated robot walks on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from wbc.errors import PlantError

#: How deep tiles reach below their lowest top, m.
_DEPTH = 0.1


class Terrain(Protocol):
    """Ground above the infinite floor z = 0, around the place where the robot starts."""

    def boxes(self) -> np.ndarray:
        """Return upright boxes, (n, 6): centre, then half sizes, m; the robot starts at 0.

        With two more columns, (n, 8), each box is turned by a roll and then a pitch, rad.
        """
        ...


@runtime_checkable
class HasFriction(Protocol):
    """A terrain whose boxes have a Coulomb coefficient other than the floor's."""

    @property
    def friction(self) -> float:
        """Coulomb coefficient between soles and boxes."""
        ...


def check_sizes(terrain: Terrain, *names: str) -> None:
    """Check that the named attributes are positive.

    Raises:
        PlantError: one of them is not.
    """
    for name in names:
        value = getattr(terrain, name)
        if not (np.isfinite(value) and value > 0.0):
            raise PlantError(
                f"{type(terrain).__name__}: {name} is {value}, it must be positive (m)"
            )


@dataclass(frozen=True, slots=True)
class Flat:
    """The infinite horizontal plane z = 0."""

    def boxes(self) -> np.ndarray:
        """Return no boxes: the floor alone."""
        return np.empty((0, 6))


@dataclass(frozen=True, slots=True)
class Tiles:
    """Square tiles of random height on the floor, flat where the robot starts.

    The patch is placed around the robot's pose at reset, rotated with it, so that a
    trial is the same wherever it takes place. Outside of it is the plain floor.

    Attributes:
        height: highest top above the floor; tops are uniform in [0, height], m.
        size: side of a tile, m.
        extent: half the side of the whole patch, m.
        clearing: no tile is nearer than this to the start, m.
        seed: seed of the heights.

    Raises:
        PlantError: a size that is not positive.
    """

    height: float = 0.03
    size: float = 0.4
    extent: float = 12.0
    clearing: float = 0.4
    seed: int = 0

    def __post_init__(self) -> None:
        check_sizes(self, "height", "size", "extent")

    def boxes(self) -> np.ndarray:
        """Return centre and half sizes of the tiles, (n, 6), m."""
        n = int(np.ceil(self.extent / self.size))
        index = np.arange(-n, n) + 0.5
        x, y = (g.ravel() for g in np.meshgrid(index * self.size, index * self.size))
        top = np.random.default_rng(self.seed).uniform(0.0, self.height, x.size)
        half = 0.5 * self.size
        far = np.maximum(abs(x), abs(y)) - half >= self.clearing
        # The boxes reach below the floor: a sole that sinks a little must not find
        # the underside of a thin tile nearer than its top.
        thick = 0.5 * self.height + _DEPTH
        sides = np.full(x.size, half)
        boxes = np.column_stack([x, y, top - thick, sides, sides, np.full(x.size, thick)])
        kept: np.ndarray = boxes[far]
        return kept

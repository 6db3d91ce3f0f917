"""A piece of terrain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Block:
    """A box of the ground that does not move.

    Attributes:
        centre: (3,) m, world.
        size: (3,) edge lengths, m.
        yaw: heading about world z, rad.
    """

    centre: np.ndarray
    size: np.ndarray
    yaw: float = 0.0

"""What the viewer's process is told when it starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from wbc.robot import Robot


@dataclass(frozen=True, eq=False)
class Order:
    """The whole of the process's input, pickled.

    Attributes:
        robot: whom to draw.
        descriptor: of the ring's shared memory.
        port: of the page; None for the first free one, 0 for any.
        rate: of the snapshots, Hz.
        boxes: (n, 6) terrain: centre and half sizes, m.
        parent: process whose end is the viewer's end.
    """

    robot: Robot
    descriptor: int
    port: int | None
    rate: float
    boxes: np.ndarray
    parent: int

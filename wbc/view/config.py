"""The configuration of the viewer's process."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from wbc.robot import Robot


@dataclass(frozen=True, eq=False)
class ViewerConfig:
    """Configuration of the viewer's process; it is pickled.

    Attributes:
        robot: the robot to draw.
        port: of the page; None for the first free one, 0 for any.
        rate: frames per second, Hz.
        boxes: (n, 6) terrain: centre and half sizes, m.
        parent: process id of the parent, with which this process ends.
    """

    robot: Robot
    port: int | None
    rate: float
    boxes: np.ndarray
    parent: int

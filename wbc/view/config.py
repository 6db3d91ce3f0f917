"""The configuration of the viewer's process."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from wbc.robot import Robot


@dataclass(frozen=True, eq=False)
class ViewerConfig:
    """The configuration of the viewer's process. It is sent there as a pickle.

    Attributes:
        robot: Robot to draw.
        port: Port of the page; None for the first free one, 0 for any.
        rate: Frame rate, Hz.
        boxes: Terrain as boxes: see `wbc.view.terrain.checked_boxes`.
    """

    robot: Robot
    port: int | None
    rate: float
    boxes: np.ndarray

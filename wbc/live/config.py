"""What the page's server is configured with when it starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wbc.teleop import ChannelConfig

if TYPE_CHECKING:
    from wbc.robot import Robot


@dataclass(frozen=True, eq=False)
class LiveServerConfig:
    """Configuration of the page's server.

    Attributes:
        robot: the robot to draw.
        boxes: (n, 6) terrain: centre, then half sizes, m.
        channel: of the commands.
        host: address to listen on.
        port: None for the first free one from 7000 on, 0 for any.
        rate: of frames and status, Hz.
        parent: process whose end ends the server.
    """

    robot: Robot
    boxes: np.ndarray
    channel: ChannelConfig
    host: str
    port: int | None
    rate: float
    parent: int

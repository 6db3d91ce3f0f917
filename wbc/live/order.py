"""What the page's process is told when it starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wbc.live.panel import Panel

if TYPE_CHECKING:
    from wbc.robot import Robot


@dataclass(frozen=True, eq=False)
class Order:
    """The first message.

    Attributes:
        robot: whom to draw.
        boxes: (n, 6) terrain: centre and half sizes, m.
        panel: what may be wanted of it.
        host: address to listen on.
        port: None for the first free one, 0 for any.
        rate: of frames and gauges, Hz.
        snapshots: descriptor of the ring of snapshots.
        gauges: descriptor of the ring of gauges.
        requests: descriptor of the ring of requests.
        shelf: descriptor of the shelf of motions.
        parent: process whose end is the page's end.
    """

    robot: Robot
    boxes: np.ndarray
    panel: Panel
    host: str
    port: int | None
    rate: float
    snapshots: int
    gauges: int
    requests: int
    shelf: int
    parent: int

"""What the node's process is told when it starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wbc.ros.network import Network

if TYPE_CHECKING:
    from wbc.robot import Robot


@dataclass(frozen=True, eq=False)
class Order:
    """The first message.

    Attributes:
        robot: whose node it is.
        name: of the node.
        space: its namespace.
        network: where it looks for others.
        update_rate: of the joint states, Hz.
        dt: control period, s.
        max_velocity: largest |forward|, |left| (m/s) and |turn| (rad/s).
        may_push: whether the plant can be pushed.
        may_reset: whether it can be reset.
        ring: descriptor of the ring.
        mailbox: descriptor of the mailbox.
        parent: process whose end is the node's end.
    """

    robot: Robot
    name: str
    space: str
    network: Network
    update_rate: float
    dt: float
    max_velocity: tuple[float, float, float]
    may_push: bool
    may_reset: bool
    ring: int
    mailbox: int
    parent: int

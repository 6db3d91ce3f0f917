"""What the node's process is told when it starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wbc.ros.network import Network

if TYPE_CHECKING:
    from wbc.motions import Motion
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
        use_sim_time: messages are stamped with the plant's time.
        dt: control period, s.
        max_velocity: largest |forward|, |left| (m/s) and |turn| (rad/s).
        motions: that may be asked for.
        may_push: whether the plant can be pushed.
        may_reset: whether it can be reset.
        ring: descriptor of the ring.
        mailbox: descriptor of the mailbox.
        shelf: descriptor of the shelf of motions.
        slip: descriptor of the slip that says why a motion was given up.
        parent: process whose end is the node's end.
    """

    robot: Robot
    name: str
    space: str
    network: Network
    update_rate: float
    use_sim_time: bool
    dt: float
    max_velocity: tuple[float, float, float]
    motions: tuple[type[Motion], ...]
    may_push: bool
    may_reset: bool
    ring: int
    mailbox: int
    shelf: int
    slip: int
    parent: int

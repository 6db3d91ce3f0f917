"""What the node's process is configured with when it starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wbc.ros.network import Network
from wbc.teleop import ChannelConfig

if TYPE_CHECKING:
    from wbc.robot import Robot
    from wbc.ros.bridge.node_topics import NodeTopic


@dataclass(frozen=True, eq=False)
class NodeConfig:
    """Configuration of the node's process.

    Attributes:
        robot: the robot whose node it is.
        name: name of the node.
        namespace: namespace of the node.
        network: where the node looks for others.
        channel: of the commands.
        update_rate: of the joint states, Hz.
        use_sim_time: whether messages are stamped with the plant's time.
        dt: control period, s.
        parent: process whose end ends the node.
        topics: further topics of the node.
    """

    robot: Robot
    name: str
    namespace: str
    network: Network
    channel: ChannelConfig
    update_rate: float
    use_sim_time: bool
    dt: float
    parent: int
    topics: tuple[NodeTopic, ...] = ()

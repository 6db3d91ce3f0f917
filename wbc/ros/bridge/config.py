"""Configuration of the process in which the robot's node runs."""

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
    """Configuration of the process in which the robot's node runs.

    Attributes:
        robot: the robot.
        name: name of the node.
        namespace: namespace of the node.
        network: DDS domain and network interface.
        channel: configuration of the command channel.
        update_rate: initial rate of the joint states, Hz.
        use_sim_time: whether messages are initially stamped with the plant's time.
        dt: control period, s.
        topics: additional topics of the node.
    """

    robot: Robot
    name: str
    namespace: str
    network: Network
    channel: ChannelConfig
    update_rate: float
    use_sim_time: bool
    dt: float
    topics: tuple[NodeTopic, ...] = ()

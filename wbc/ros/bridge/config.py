"""Configuration of the process in which the robot's node runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

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
        parameters: initial values of parameters by their names, which replace the defaults.
        remappings: new names of topics, services and actions by their names.
        mesh_files: whether `robot_description` names the files of meshes instead of packages.
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
    parameters: Mapping[str, Any] = field(default_factory=dict)
    remappings: Mapping[str, str] = field(default_factory=dict)
    mesh_files: bool = False

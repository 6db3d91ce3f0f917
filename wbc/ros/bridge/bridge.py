"""`Bridge`: connects a robot in a running loop to a ROS 2 system."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from wbc.process import ChildProcess
from wbc.ros.bridge.config import NodeConfig
from wbc.ros.bridge.node_topics import NodeTopic
from wbc.ros.dds_types import import_cyclonedds
from wbc.ros.errors import RosError
from wbc.ros.network import Network
from wbc.runtime.process_observer import ProcessObserver

if TYPE_CHECKING:
    from wbc.teleop import CommandHandler


class Bridge(ProcessObserver):
    """Publishes a robot's state to a ROS 2 system and receives commands from it.

    DDS runs in another process, which reads the loop's ticks from shared memory. The loop never
    waits for it, and continues if it dies.

    Example:
        >>> with CommandHandler(player, plant) as handler, Bridge(handler) as bridge:
        ...     wbc.teleop.run(handler, 3600.0, clients=[bridge])

    Args:
        handler: Command handler that applies the node's commands.
        name: Name of the node.
        namespace: Namespace of the node.
        network: Domain and interface; from the environment by default.
        update_rate: Rate of the joint states, Hz; initial value of the node's parameter.
        use_sim_time: Whether messages carry plant time instead of system time; initial value of
            the node's parameter.
        parameters: Initial values of the node's parameters by their names, as `-p` gives them.
        remappings: New names of topics, services and actions by their names, as `-r` gives them.
        mesh_files: Whether `robot_description` names meshes by `file://` addresses, which RViz on
            this machine finds without the packages of the robot's description.
        topics: Additional topics beside those of `wbc.ros.bridge.node_topics`.

    Attributes:
        name: Fully qualified name of the node.
        network: Domain and interface.
        reset_hint: Text that tells a user how to reset the robot.
        stream: Stream that the node reads, see `wbc.runtime.protocols.StreamObserver`.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: The node cannot be created.
    """

    reset_hint = "call the service /reset_robot"

    def __init__(
        self,
        handler: CommandHandler,
        *,
        name: str = "wbc",
        namespace: str = "/",
        network: Network | None = None,
        update_rate: float = 50.0,
        use_sim_time: bool = False,
        parameters: Mapping[str, Any] | None = None,
        remappings: Mapping[str, str] | None = None,
        mesh_files: bool = False,
        topics: Sequence[NodeTopic] = (),
    ) -> None:
        import_cyclonedds()
        for topic in topics:
            topic.check_importable()
        robot, dt = handler.player.robot, handler.player.dt
        channel = handler.open_channel().config
        self.network = network or Network.from_environment()
        config = NodeConfig(
            robot=robot,
            name=name,
            namespace=namespace,
            network=self.network,
            channel=channel,
            update_rate=update_rate,
            use_sim_time=use_sim_time,
            dt=dt,
            topics=tuple(topics),
            parameters=dict(parameters or {}),
            remappings=dict(remappings or {}),
            mesh_files=mesh_files,
        )
        super().__init__(
            ChildProcess("wbc.ros.bridge.server", channel.descriptors, title="the ROS 2 node")
        )
        self.name: str = self._configure(config, RosError)["node"]

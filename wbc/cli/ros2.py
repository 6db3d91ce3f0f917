"""`wbc ros2`: nodes and graph introspection on a ROS 2 network, without ROS 2."""

from __future__ import annotations

import functools
import math
import os
import sys
import time
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from wbc.cli import teleoperated_run
from wbc.cli.argument_types import Argument, Seconds, number, positive_number, whole_number
from wbc.cli.exit_code import ExitCode
from wbc.cli.parser import Function, Parser, set_commands
from wbc.cli.simulation import Session, Simulation, SimulationOptions
from wbc.errors import WbcError, did_you_mean
from wbc.robot.registry import data_file_folder
from wbc.ros import DurabilityPolicy, Network, Node, QoSProfile, ReliabilityPolicy, RosError
from wbc.ros.bridge import Bridge
from wbc.ros.graph_snapshot import TopicInfo
from wbc.ros.joint_publisher import JointPublisher
from wbc.ros.message_yaml import get_field, to_yaml
from wbc.ros.names import is_hidden
from wbc.ros.rate_statistics import RateStatistics
from wbc.ros.rosout import log_to_rosout
from wbc.teleop import CommandHandler
from wbc.view import Meshcat

Domain = Annotated[int, Argument("ID", functools.partial(whole_number, high=232))]
Rate = Annotated[float, Argument("HZ", number)]

_DESCRIPTION = """\
Run ROS 2 nodes over DDS (Cyclone DDS) and inspect the ROS graph, without a ROS installation.

Nodes are met on this machine only, unless --interface or one of these environment variables
selects another network: ROS_DOMAIN_ID, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_LOCALHOST_ONLY,
ROS_STATIC_PEERS, CYCLONEDDS_URI. A ROS 2 system looks for nodes in the subnet: set
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST there, or CYCLONEDDS_URI to what `wbc ros2 uri` prints.
"""


@dataclass(frozen=True)
class NetworkOptions:
    """Without these options the environment variables of ROS 2 select the network.

    Attributes:
        domain: DDS domain (default: ROS_DOMAIN_ID, or 0).
        interface: the only network interface to use, by name or address (default: loopback).
    """

    title: ClassVar[str] = "network"

    domain: Domain | None = None
    interface: Annotated[str | None, Argument("NAME")] = None

    def network(self) -> Network:
        """Return the network that options and environment select."""
        return Network.from_environment(self.domain, self.interface)

    def introspection_node(self) -> Node:
        """Return a node that listings hide by its leading underscore, as the tools of ROS 2 do."""
        return Node(f"_wbc_ros2_{os.getpid()}", network=self.network())


@dataclass(frozen=True)
class TopicOptions:
    """A topic, and the network where it is.

    Attributes:
        topic: e.g. /joint_states.
        network: network of the topic.
        wait: time to wait for the topic to appear, s.
    """

    topic: str
    network: NetworkOptions
    wait: Seconds = 5.0

    def find(self, node: Node) -> TopicInfo:
        """Wait for the topic; return it with all endpoints, whose QoS is then known."""
        name = node.resolve_topic_name(self.topic)
        node.graph.wait_for(lambda graph: name in graph.topics(), self.wait)
        topics = node.graph.settle().topics()
        if name not in topics:
            near = did_you_mean(name, topics)
            hint = "" if topics else f"; no node was met ({node.network.hint})"
            raise RosError(f"no node publishes or subscribes to '{name}'{near}{hint}")
        return topics[name]


def _nodes(network: NetworkOptions, *, all: bool = False) -> None:
    """List the nodes.

    Args:
        network: the network.
        all: include hidden names.
    """
    with network.introspection_node() as node:
        nodes = node.graph.settle().nodes
        _print_names(dict.fromkeys(nodes, ""), all)
        if not nodes:
            print(f"no node was met ({node.network.hint})", file=sys.stderr)


def _topics(network: NetworkOptions, *, all: bool = False) -> None:
    """List the topics.

    Args:
        network: the network.
        all: include hidden names.
    """
    with network.introspection_node() as node:
        topics = node.graph.settle().topics()
        _print_names({name: ", ".join(topic.types) for name, topic in topics.items()}, all)


def _services(network: NetworkOptions, *, all: bool = False) -> None:
    """List the services.

    Args:
        network: the network.
        all: include hidden names.
    """
    with network.introspection_node() as node:
        _print_names(node.graph.settle().services(), all)


def _print_names(types: dict[str, str], hidden: bool) -> None:
    for name, type_name in types.items():
        if hidden or not is_hidden(name):
            print(f"{name} [{type_name}]" if type_name else name)


def _uri(network: NetworkOptions) -> None:
    """Print the CYCLONEDDS_URI for a ROS 2 system on this network."""
    print(network.network().xml())


def _info(topic: TopicOptions) -> None:
    """Print the publishers and subscriptions of a topic."""
    with topic.network.introspection_node() as node:
        found = topic.find(node)
    print(f"{found.name}: {', '.join(found.types)}")
    for what in ("publishers", "subscriptions"):
        endpoints = getattr(found, what)
        print(f"\n{what}: {len(endpoints)}")
        for endpoint in endpoints:
            print(
                f"  {endpoint.node or '(unknown node)'}\n"
                f"    type hash: {endpoint.type_hash or 'not announced'}\n"
                f"    quality of service: {endpoint.qos_profile}\n"
                f"    endpoint id: {endpoint.gid.hex('.')}"
            )


def _compatible_qos(topic: TopicInfo) -> QoSProfile:
    """Return the strictest quality of service that all publishers of a topic offer."""
    offered = [publisher.qos_profile for publisher in topic.publishers]
    reliable = bool(offered) and all(qos.reliable for qos in offered)
    transient_local = bool(offered) and all(qos.transient_local for qos in offered)
    return QoSProfile(
        1000,
        ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        DurabilityPolicy.TRANSIENT_LOCAL if transient_local else DurabilityPolicy.VOLATILE,
    )


def _echo(
    topic: TopicOptions,
    *,
    field: Annotated[str | None, Argument("PATH")] = None,
    count: Annotated[float, Argument("N", positive_number, "-n")] = math.inf,
) -> None:
    """Print the messages of a topic.

    Args:
        topic: the topic.
        field: print one field only, e.g. position[3].
        count: stop after N messages.
    """
    printed = 0

    def show(message: Any) -> None:
        nonlocal printed
        if printed >= count:
            return
        try:
            value = message if field is None else get_field(message, field)
        except LookupError as error:
            raise WbcError(str(error)) from error
        print(f"{to_yaml(value)}\n---")
        printed += 1

    with topic.network.introspection_node() as node:
        found = topic.find(node)
        if len(found.types) != 1:
            raise RosError(f"'{found.name}' has more than one type: {', '.join(found.types)}")
        node.create_subscription(found.types[0], found.name, show, _compatible_qos(found))
        node.spin_until(lambda: printed >= count)


def _hz(
    topic: TopicOptions,
    *,
    count: Annotated[float, Argument("N", positive_number, "-n")] = math.inf,
    window: Annotated[int, Argument("N", positive_number)] = 1000,
) -> None:
    """Measure the rate at which messages of a topic arrive.

    Args:
        topic: the topic.
        count: stop after N measurements.
        window: number of messages to evaluate.
    """
    statistics = RateStatistics(window)
    with topic.network.introspection_node() as node:
        found = topic.find(node)
        node.create_raw_subscription(
            found.dds_type_name,
            found.name,
            lambda _, info: statistics.add(time.monotonic(), info.size),
            _compatible_qos(found),
            found.type_hash,
        )
        # A publisher may not have discovered this subscription yet.
        node.spin_until(lambda: statistics.hz > 0.0, topic.wait)
        shown = 0
        while shown < count:
            node.spin(timeout_sec=1.0)
            print(statistics.summary())
            shown += 1


def _joint_publisher(
    network: NetworkOptions, *, rate: Rate = 50.0, duration: Seconds = math.inf
) -> None:
    """Publish a pattern of fifteen joints.

    Args:
        network: the network.
        rate: rate of /joint_states, 1 to 500 Hz.
        duration: stop after S seconds.
    """
    with Node("joint_publisher", network=network.network()) as node, log_to_rosout(node):
        JointPublisher(node, rate, data_file_folder() / "simple_humanoid.urdf")
        print(f"[INFO] [joint_publisher]: Joint publisher started at {rate} Hz")
        node.spin(timeout_sec=duration)


def _walk(
    simulation: SimulationOptions,
    network: NetworkOptions,
    *,
    rate: Rate = 50.0,
    view: bool = False,
    as_fast_as_possible: bool = False,
    sim_time: bool = False,
    duration: Seconds = teleoperated_run.DURATION,
) -> ExitCode:
    """Simulate a robot that a ROS 2 system drives.

    Args:
        simulation: robot and ground.
        network: the network.
        rate: rate of /joint_states, 1 to 500 Hz; the node's parameter update_rate.
        view: show the robot in the browser.
        as_fast_as_possible: run faster than real time.
        sim_time: stamp messages with the time of /clock, for nodes with use_sim_time; the node's
            parameter use_sim_time.
        duration: duration, s.
    """
    simulated = Simulation(simulation)
    robot = simulated.robot

    def connect(handler: CommandHandler, session: Session) -> Bridge:
        if view:
            viewer = Meshcat(robot, boxes=simulated.boxes)
            session.observers.append(session.stack.enter_context(viewer))
        bridge = Bridge(handler, network=network.network(), update_rate=rate, use_sim_time=sim_time)
        session.stack.enter_context(bridge)
        where = f"DDS domain {bridge.network.domain_id}, {bridge.network.scope}"
        print(
            f"[INFO] [{bridge.name}]: {robot.name} is ready; listening on /cmd_vel ({where}). "
            "Press Ctrl-C to stop."
        )
        return bridge

    # The loop keeps the time, which need not be that of the wall clock.
    return teleoperated_run.run(
        simulated, duration, connect, owns_clock=False, real_time=not as_fast_as_possible
    )


VERBS: dict[str, Function] = {
    "nodes": _nodes,
    "topics": _topics,
    "services": _services,
    "info": _info,
    "echo": _echo,
    "hz": _hz,
    "joint-publisher": _joint_publisher,
    "walk": _walk,
    "uri": _uri,
}


def add_verbs(parser: Parser) -> None:
    """Add the verbs."""
    parser.description = _DESCRIPTION
    set_commands(parser, VERBS)

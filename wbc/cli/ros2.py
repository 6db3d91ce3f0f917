"""`wbc ros2`: nodes and graph introspection on a ROS 2 network, without ROS 2."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING, Any

from wbc.cli import ros2_walk
from wbc.cli.parser import number, seconds
from wbc.cli.ros2_options import add_verb, count, network
from wbc.errors import WbcError

if TYPE_CHECKING:
    from wbc.ros import Node, QoSProfile
    from wbc.ros.graph_snapshot import TopicEndpointInfo, TopicInfo

_DESCRIPTION = """\
Runs ROS 2 nodes over DDS (Cyclone DDS) and inspects the ROS graph, without a ROS installation.

The network is the loopback interface unless --interface or one of these environment variables
selects another: ROS_DOMAIN_ID, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_LOCALHOST_ONLY,
ROS_STATIC_PEERS, CYCLONEDDS_URI. `wbc ros2 uri` prints the setting for a ROS 2 system that is to
use the same interface.
"""


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "ros2",
        help="run a ROS 2 node or inspect the ROS graph",
        description=_DESCRIPTION,
    )
    verbs = parser.add_subparsers(title="verbs", metavar="VERB", required=True)
    nodes = add_verb(verbs, "nodes", "list the nodes", _nodes)
    topics = add_verb(verbs, "topics", "list the topics", _topics)
    services = add_verb(verbs, "services", "list the services", _services)
    for listing in (nodes, topics, services):
        listing.add_argument("--all", action="store_true", help="include hidden names")
    info = add_verb(verbs, "info", "print the publishers and subscriptions of a topic", _info)
    echo = add_verb(verbs, "echo", "print the messages of a topic", _echo)
    echo.add_argument("--field", metavar="PATH", help="print one field only, e.g. position[3]")
    echo.add_argument("-n", type=count, metavar="N", help="stop after N messages")
    hz = add_verb(verbs, "hz", "measure the rate at which messages of a topic arrive", _hz)
    hz.add_argument("-n", type=count, metavar="N", help="stop after N measurements")
    hz.add_argument(
        "--window",
        type=count,
        default=1000,
        metavar="N",
        help="number of messages to evaluate (default: 1000)",
    )
    for verb in (info, echo, hz):
        verb.add_argument("topic", metavar="TOPIC", help="e.g. /joint_states")
        verb.add_argument(
            "--wait",
            type=seconds,
            default=5.0,
            metavar="S",
            help="time to wait for the topic to appear, s (default: 5)",
        )
    publisher = add_verb(
        verbs,
        "joint-publisher",
        "publish a pattern of fifteen joints",
        _joint_publisher,
    )
    publisher.add_argument(
        "--rate", type=number, default=50.0, metavar="HZ", help="1 to 500 Hz (default: 50)"
    )
    publisher.add_argument("--duration", type=seconds, metavar="S", help="stop after S seconds")
    ros2_walk.add_to(verbs)
    add_verb(verbs, "uri", "print the CYCLONEDDS_URI for a ROS 2 system on this network", _uri)


def _introspection_node(options: argparse.Namespace) -> Node:
    import os

    from wbc.ros import Node

    # The leading underscore hides it from listings, as it does for the tools of ROS 2.
    return Node(f"_wbc_ros2_{os.getpid()}", network=network(options))


def _nodes(options: argparse.Namespace) -> int:
    with _introspection_node(options) as node:
        _print_names(options, dict.fromkeys(node.graph.settle().nodes, ""))
    return 0


def _topics(options: argparse.Namespace) -> int:
    with _introspection_node(options) as node:
        topics = node.graph.settle().topics()
        _print_names(options, {name: ", ".join(topic.types) for name, topic in topics.items()})
    return 0


def _services(options: argparse.Namespace) -> int:
    with _introspection_node(options) as node:
        _print_names(options, node.graph.settle().services())
    return 0


def _print_names(options: argparse.Namespace, types: dict[str, str]) -> None:
    from wbc.ros.names import is_hidden

    for name, type_name in types.items():
        if options.all or not is_hidden(name):
            print(f"{name} [{type_name}]" if type_name else name)


def _uri(options: argparse.Namespace) -> int:
    print(network(options).xml())
    return 0


def _info(options: argparse.Namespace) -> int:
    with _introspection_node(options) as node:
        topic = _find_topic(options, node)
        print(f"{topic.name}: {', '.join(topic.types)}")
        for what, endpoints in (
            ("publishers", topic.publishers),
            ("subscriptions", topic.subscriptions),
        ):
            print(f"\n{what}: {len(endpoints)}")
            for endpoint in endpoints:
                print(_endpoint_text(endpoint))
    return 0


def _endpoint_text(endpoint: TopicEndpointInfo) -> str:
    return (
        f"  {endpoint.node or '(unknown node)'}\n"
        f"    type hash: {endpoint.type_hash or 'not announced'}\n"
        f"    quality of service: {endpoint.qos_profile}\n"
        f"    endpoint id: {endpoint.gid.hex('.')}"
    )


def _find_topic(options: argparse.Namespace, node: Node) -> TopicInfo:
    """Wait for the topic; return it with all endpoints, whose quality of service is then known."""
    from wbc.errors import did_you_mean
    from wbc.ros import RosError

    name = node.resolve_topic_name(options.topic)
    node.graph.wait_for(lambda graph: name in graph.topics(), options.wait)
    topics = node.graph.settle().topics()
    if name not in topics:
        raise RosError(f"no node publishes or subscribes to '{name}'{did_you_mean(name, topics)}")
    return topics[name]


def _compatible_qos(topic: TopicInfo) -> QoSProfile:
    """Return the strictest quality of service that all publishers of a topic offer."""
    from wbc.ros import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    offered = [publisher.qos_profile for publisher in topic.publishers]
    reliable = bool(offered) and all(qos.reliable for qos in offered)
    transient_local = bool(offered) and all(qos.transient_local for qos in offered)
    return QoSProfile(
        1000,
        ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        DurabilityPolicy.TRANSIENT_LOCAL if transient_local else DurabilityPolicy.VOLATILE,
    )


def _type_name(topic: TopicInfo) -> str:
    from wbc.ros import RosError

    if len(topic.types) != 1:
        raise RosError(f"'{topic.name}' has more than one type: {', '.join(topic.types)}")
    return topic.types[0]


def _echo(options: argparse.Namespace) -> int:
    from wbc.ros.message_yaml import get_field, to_yaml

    printed = 0

    def show(message: Any) -> None:
        nonlocal printed
        if options.n is not None and printed >= options.n:
            return
        try:
            value = message if options.field is None else get_field(message, options.field)
        except LookupError as error:
            raise WbcError(str(error)) from error
        print(f"{to_yaml(value)}\n---", flush=True)
        printed += 1

    with _introspection_node(options) as node:
        topic = _find_topic(options, node)
        node.create_subscription(_type_name(topic), topic.name, show, _compatible_qos(topic))
        node.spin_until(lambda: options.n is not None and printed >= options.n)
    return 0


def _hz(options: argparse.Namespace) -> int:
    from wbc.ros.rate_statistics import RateStatistics

    statistics = RateStatistics(options.window)
    with _introspection_node(options) as node:
        topic = _find_topic(options, node)
        node.create_raw_subscription(
            topic.dds_type_name,
            topic.name,
            lambda _, info: statistics.add(time.monotonic(), info.size),
            _compatible_qos(topic),
        )
        # A publisher may not have discovered this subscription yet.
        node.spin_until(lambda: statistics.hz > 0.0, options.wait)
        shown = 0
        while options.n is None or shown < options.n:
            node.spin(timeout_sec=1.0)
            print(statistics.summary(), flush=True)
            shown += 1
    return 0


def _joint_publisher(options: argparse.Namespace) -> int:
    from wbc.robot.registry import data_file_folder
    from wbc.ros import Node
    from wbc.ros.joint_publisher import JointPublisher
    from wbc.ros.rosout import log_to_rosout

    with Node("joint_publisher", network=network(options)) as node, log_to_rosout(node):
        JointPublisher(node, options.rate, data_file_folder() / "simple_humanoid.urdf")
        print(f"[INFO] [joint_publisher]: Joint publisher started at {options.rate} Hz", flush=True)
        node.spin(timeout_sec=options.duration or float("inf"))
    return 0

"""`wbc ros2`: talk to a ROS 2 system, or look at one, without ROS 2."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING, Any

from wbc.cli import ros2_walk
from wbc.cli.parser import number, seconds
from wbc.cli.ros2_options import add_verb, count, network
from wbc.errors import WbcError

if TYPE_CHECKING:
    from wbc.ros import Node
    from wbc.ros.graph import Endpoint, Graph, Topic

_DESCRIPTION = """\
Nodes over DDS (Cyclone) that a ROS 2 system takes for its own, and looks at its graph.

They stay on the loopback interface unless --interface or one of the usual variables says
otherwise: ROS_DOMAIN_ID, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_LOCALHOST_ONLY, ROS_STATIC_PEERS,
CYCLONEDDS_URI. `wbc ros2 uri` prints the setting that brings a ROS 2 system there.
"""


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "ros2",
        help="be a ROS 2 node, or look at the graph, without ROS 2",
        description=_DESCRIPTION,
    )
    verbs = parser.add_subparsers(title="verbs", metavar="VERB", required=True)
    nodes = add_verb(verbs, "nodes", "list the nodes", _nodes)
    topics = add_verb(verbs, "topics", "list the topics", _topics)
    services = add_verb(verbs, "services", "list the services", _services)
    for listing in (nodes, topics, services):
        listing.add_argument("--all", action="store_true", help="hidden ones too")
    info = add_verb(verbs, "info", "who publishes a topic, who listens, and how", _info)
    echo = add_verb(verbs, "echo", "print the messages of a topic", _echo)
    echo.add_argument("--field", metavar="PATH", help="print one field alone, e.g. position[3]")
    echo.add_argument("-n", type=count, metavar="N", help="end after N messages")
    hz = add_verb(verbs, "hz", "measure how often messages of a topic come", _hz)
    hz.add_argument("-n", type=count, metavar="N", help="end after N measurements")
    hz.add_argument(
        "--window", type=count, default=1000, metavar="N", help="messages looked at (default 1000)"
    )
    for verb in (info, echo, hz):
        verb.add_argument("topic", metavar="TOPIC", help="e.g. /joint_states")
        verb.add_argument(
            "--wait", type=seconds, default=5.0, metavar="S", help="for the topic (default: 5 s)"
        )
    publisher = add_verb(
        verbs, "joint-publisher", "publish fifteen joints that swing like walking", _joint_publisher
    )
    publisher.add_argument(
        "--rate", type=number, default=50.0, metavar="HZ", help="1 to 500 Hz (default: 50)"
    )
    publisher.add_argument("--duration", type=seconds, metavar="S", help="end after so many s")
    ros2_walk.add_to(verbs)
    add_verb(verbs, "uri", "print CYCLONEDDS_URI that brings a ROS 2 system here", _uri)


def _looker(options: argparse.Namespace) -> tuple[Node, Graph]:
    import os

    from wbc.ros import Node
    from wbc.ros.graph import Graph

    # A leading underscore hides it from listings, as the node of ROS 2's own tools.
    node = Node(f"_wbc_ros2_{os.getpid()}", network=network(options))
    return node, Graph(node)


def _nodes(options: argparse.Namespace) -> int:
    from wbc.ros.names import is_hidden

    node, graph = _looker(options)
    with node:
        for name in graph.settle().nodes:
            if options.all or not is_hidden(name):
                print(name)
    return 0


def _topics(options: argparse.Namespace) -> int:
    from wbc.ros.names import is_hidden

    node, graph = _looker(options)
    with node:
        for name, topic in graph.settle().topics().items():
            if options.all or not is_hidden(name):
                print(f"{name} [{', '.join(topic.types)}]")
    return 0


def _services(options: argparse.Namespace) -> int:
    from wbc.ros.names import is_hidden

    node, graph = _looker(options)
    with node:
        for name, kind in graph.settle().services().items():
            if options.all or not is_hidden(name):
                print(f"{name} [{kind}]")
    return 0


def _uri(options: argparse.Namespace) -> int:
    print(network(options).xml())
    return 0


def _info(options: argparse.Namespace) -> int:
    node, graph = _looker(options)
    with node:
        topic = _find(options, node, graph)
        print(f"{topic.name}: {', '.join(topic.types)}")
        for what, endpoints in (
            ("publishers", topic.publishers),
            ("subscriptions", topic.subscriptions),
        ):
            print(f"\n{what}: {len(endpoints)}")
            for endpoint in endpoints:
                print(_endpoint_text(endpoint))
    return 0


def _endpoint_text(endpoint: Endpoint) -> str:
    qos = endpoint.qos
    terms = [
        "reliable" if qos.reliable else "best effort",
        "transient local" if qos.latched else "volatile",
        f"keep last {qos.depth}" if qos.depth else "keep all",
    ]
    return (
        f"  {endpoint.node or '(a node that does not tell its name)'}\n"
        f"    type hash: {endpoint.type_hash or 'not told'}\n"
        f"    quality of service: {', '.join(terms)}\n"
        f"    id: {endpoint.gid.hex('.')}"
    )


def _find(options: argparse.Namespace, node: Node, graph: Graph) -> Topic:
    """The topic, once somebody has it; with all who have it, so that their terms are known."""
    from wbc.errors import did_you_mean
    from wbc.ros import RosError

    name = node.resolve(options.topic)
    graph.wait_for(lambda seen: name in seen.topics(), options.wait)
    topics = graph.settle().topics()
    if name not in topics:
        raise RosError(f"nobody has the topic '{name}'{did_you_mean(name, topics)}")
    return topics[name]


def _listening_qos(topic: Topic) -> Any:
    """What can be had from all who publish it: reliable and latched only if all are."""
    from wbc.ros import Qos

    publishers = topic.publishers
    reliable = bool(publishers) and all(p.qos.reliable for p in publishers)
    latched = bool(publishers) and all(p.qos.latched for p in publishers)
    return Qos(depth=1000, reliable=reliable, latched=latched)


def _the_type(topic: Topic) -> str:
    from wbc.ros import RosError

    if len(topic.types) != 1:
        kinds = ", ".join(topic.types)
        raise RosError(f"'{topic.name}' carries {kinds}: nobody can tell which is meant")
    return topic.types[0]


def _echo(options: argparse.Namespace) -> int:
    from wbc.ros.text import as_yaml, part, value_text

    node, graph = _looker(options)
    printed = 0

    def show(message: Any, _: Any) -> None:
        nonlocal printed
        if options.n is not None and printed >= options.n:
            return
        if options.field is None:
            text = as_yaml(message)
        else:
            try:
                text = value_text(part(message, options.field))
            except LookupError as error:
                raise WbcError(str(error)) from error
        print(f"{text}\n---", flush=True)
        printed += 1

    with node:
        topic = _find(options, node, graph)
        node.subscription(_the_type(topic), topic.name, show, _listening_qos(topic))
        node.spin(lambda: options.n is not None and printed >= options.n)
    return 0


def _hz(options: argparse.Namespace) -> int:
    from wbc.ros.rate import Rate

    node, graph = _looker(options)
    rate = Rate(options.window)
    with node:
        topic = _find(options, node, graph)
        node.listen(
            topic.dds_type,
            topic.name,
            lambda _, info: rate.note(time.monotonic(), info.size),
            _listening_qos(topic),
        )
        node.spin(lambda: rate.hz > 0.0, options.wait)  # who publishes may not know us yet
        shown = 0
        while options.n is None or shown < options.n:
            node.spin(timeout=1.0)
            print(rate.text(), flush=True)
            shown += 1
    return 0


def _joint_publisher(options: argparse.Namespace) -> int:
    from wbc.robot.registry import data_file_folder
    from wbc.ros import Node
    from wbc.ros.joint_publisher import JointPublisher
    from wbc.ros.rosout import speaking

    with Node("joint_publisher", network=network(options)) as node, speaking(node):
        JointPublisher(node, options.rate, data_file_folder() / "simple_humanoid.urdf")
        print(f"[INFO] [joint_publisher]: Joint publisher started at {options.rate} Hz", flush=True)
        node.spin(timeout=options.duration or float("inf"))
    return 0

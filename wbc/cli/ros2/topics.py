"""`wbc ros2 topic`."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Annotated, Any

from wbc.cli.argument_types import Argument, Seconds, number, positive_number
from wbc.cli.ros2.network import NetworkOptions, print_names
from wbc.errors import WbcError, did_you_mean
from wbc.messages import message_type
from wbc.ros import DurabilityPolicy, Node, QoSProfile, ReliabilityPolicy, RosError
from wbc.ros.graph_snapshot import TopicInfo
from wbc.ros.message_yaml import from_yaml, get_field, to_yaml
from wbc.ros.rate_statistics import RateStatistics


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


def list_topics(network: NetworkOptions, *, all: bool = False) -> None:
    """List the topics.

    Args:
        network: the network.
        all: include hidden names.
    """
    with network.introspection_node() as node:
        topics = node.graph.settle().topics()
        print_names({name: ", ".join(topic.types) for name, topic in topics.items()}, all)


def print_topic(topic: TopicOptions) -> None:
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


def echo(
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


def hz(
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


def publish(
    topic: str,
    type: str,
    values: tuple[str, ...],
    network: NetworkOptions,
    *,
    rate: Annotated[float, Argument("HZ", number, "-r")] = 1.0,
    times: Annotated[float, Argument("N", positive_number, "-t")] = math.inf,
    once: Annotated[bool, Argument("", flag="-1")] = False,
    wait: Seconds = 5.0,
) -> None:
    """Publish messages on a topic.

    Args:
        topic: e.g. /cmd_vel.
        type: type of the messages, e.g. geometry_msgs/msg/Twist.
        values: fields that are not zero, as YAML, e.g. "{linear: {x: 0.2}}".
        network: the network.
        rate: rate of the messages.
        times: stop after N messages.
        once: publish one message, and stop.
        wait: time to wait for a subscription, s, if the number of messages is limited.
    """
    message = from_yaml(message_type(type), " ".join(values))
    count = 1.0 if once else times
    with network.introspection_node() as node:
        publisher = node.create_publisher(message_type(type), topic)
        if math.isfinite(count) and not node.spin_until(publisher.get_subscription_count, wait):
            raise RosError(
                f"nobody subscribes to '{publisher.topic_name}' as {type} ({node.network.hint})"
            )
        sent = 0

        def send() -> None:
            nonlocal sent
            if sent < count:
                publisher.publish(message)
                sent += 1

        if not (math.isfinite(rate) and rate > 0.0):
            raise RosError(f"a rate of {rate:g} Hz is not positive")
        timer = node.create_timer(1.0 / rate, send)
        timer.next_call -= timer.period
        node.spin_until(lambda: sent >= count)
        node.spin(timeout_sec=0.2)  # messages that were lost are sent again
    print(f"published {sent} {'message' if sent == 1 else 'messages'}")

"""The nodes, topics and services of a ROS graph at one instant."""

from __future__ import annotations

from dataclasses import dataclass, field

from wbc.ros import names
from wbc.ros.qos import QoSProfile


@dataclass(frozen=True)
class TopicEndpointInfo:
    """A publisher or subscription of some node.

    Attributes:
        topic: ROS name of the topic.
        prefix: "rt" for a topic, "rq" and "rr" for the requests and replies of a service.
        type_name: `pkg/msg/Name`.
        dds_type_name: name of the type in DDS.
        node: fully qualified name of the node; empty if not known.
        qos_profile: quality of service.
        type_hash: `RIHS01_…`; empty if not announced.
        user_data: USER_DATA of the endpoint.
        gid: 16-byte id.
    """

    topic: str
    prefix: str
    type_name: str
    dds_type_name: str
    node: str
    qos_profile: QoSProfile
    type_hash: str
    user_data: str
    gid: bytes


@dataclass
class TopicInfo:
    """A topic.

    Attributes:
        name: fully qualified name.
        publishers: its publishers.
        subscriptions: its subscriptions.
    """

    name: str
    publishers: list[TopicEndpointInfo] = field(default_factory=list)
    subscriptions: list[TopicEndpointInfo] = field(default_factory=list)

    @property
    def types(self) -> list[str]:
        """Names of its types, sorted; more than one if the endpoints disagree."""
        return sorted({e.type_name for e in (*self.publishers, *self.subscriptions)})

    @property
    def dds_type_name(self) -> str:
        """Name of its type in DDS."""
        return next(e.dds_type_name for e in (*self.publishers, *self.subscriptions))


@dataclass(frozen=True)
class GraphSnapshot:
    """The graph as discovered at one instant.

    Attributes:
        nodes: fully qualified names of all nodes, sorted; a name may occur more than once.
        publishers: all publishers, including those of services.
        subscriptions: all subscriptions, including those of services.
    """

    nodes: tuple[str, ...]
    publishers: tuple[TopicEndpointInfo, ...]
    subscriptions: tuple[TopicEndpointInfo, ...]

    @property
    def endpoints(self) -> tuple[TopicEndpointInfo, ...]:
        """Publishers, then subscriptions."""
        return self.publishers + self.subscriptions

    def topics(self) -> dict[str, TopicInfo]:
        """Return all topics by name, without those of services."""
        found: dict[str, TopicInfo] = {}
        for endpoint in self.publishers:
            if endpoint.prefix == names.TOPIC:
                name = endpoint.topic
                found.setdefault(name, TopicInfo(name)).publishers.append(endpoint)
        for endpoint in self.subscriptions:
            if endpoint.prefix == names.TOPIC:
                name = endpoint.topic
                found.setdefault(name, TopicInfo(name)).subscriptions.append(endpoint)
        return dict(sorted(found.items()))

    def topic(self, name: str) -> TopicInfo:
        """Return a topic by its fully qualified name; without endpoints if nobody has it."""
        return self.topics().get(name, TopicInfo(name))

    def services(self) -> dict[str, str]:
        """Return names and types of all services that have a server."""
        return {
            e.topic: names.service_type_name(e.type_name)
            for e in sorted(self.subscriptions, key=lambda e: e.topic)
            if e.prefix == names.REQUEST
        }

"""The nodes, topics and services of a ROS graph at one instant."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from wbc.ros import names
from wbc.ros.qos import QoSProfile


class EndpointType(Enum):
    """Direction of an endpoint."""

    PUBLISHER = "publisher"
    SUBSCRIPTION = "subscription"


@dataclass(frozen=True)
class TopicEndpointInfo:
    """A publisher or subscription of some node.

    Attributes:
        endpoint_type: publisher or subscription.
        topic: ROS name of the topic.
        prefix: "rt" for a topic, "rq" and "rr" for the requests and replies of a service.
        dds_type_name: name of the type in DDS.
        node: fully qualified name of the node; empty if not known.
        qos_profile: quality of service.
        user_data: items of the endpoint's USER_DATA.
        gid: 16-byte id.
    """

    endpoint_type: EndpointType
    topic: str
    prefix: str
    dds_type_name: str
    node: str
    qos_profile: QoSProfile
    user_data: dict[str, str]
    gid: bytes

    @property
    def type_name(self) -> str:
        """Name of the type, `pkg/msg/Name`."""
        return names.ros_type_name(self.dds_type_name)

    @property
    def type_hash(self) -> str:
        """Hash of the type, `RIHS01_…`; empty if not announced."""
        return self.user_data.get("typehash", "")


@dataclass
class TopicInfo:
    """A topic.

    Attributes:
        name: fully qualified name.
        endpoints: its publishers and subscriptions.
    """

    name: str
    endpoints: list[TopicEndpointInfo] = field(default_factory=list)

    @property
    def publishers(self) -> list[TopicEndpointInfo]:
        """Its publishers."""
        return [e for e in self.endpoints if e.endpoint_type is EndpointType.PUBLISHER]

    @property
    def subscriptions(self) -> list[TopicEndpointInfo]:
        """Its subscriptions."""
        return [e for e in self.endpoints if e.endpoint_type is EndpointType.SUBSCRIPTION]

    @property
    def types(self) -> list[str]:
        """Names of its types, sorted; more than one if the endpoints disagree."""
        return sorted({endpoint.type_name for endpoint in self.endpoints})

    @property
    def dds_type_name(self) -> str:
        """Name of its type in DDS."""
        return self.endpoints[0].dds_type_name

    @property
    def type_hash(self) -> str:
        """Hash of its type; empty if no endpoint announces one."""
        return next((e.type_hash for e in self.endpoints if e.type_hash), "")


@dataclass(frozen=True)
class GraphSnapshot:
    """The graph as discovered at one instant.

    Attributes:
        nodes: fully qualified names of all nodes, sorted; a name may occur more than once.
        endpoints: all publishers, then all subscriptions, including those of services.
    """

    nodes: tuple[str, ...]
    endpoints: tuple[TopicEndpointInfo, ...]

    def topics(self) -> dict[str, TopicInfo]:
        """Return all topics by name, without those of services."""
        found: dict[str, TopicInfo] = {}
        for endpoint in self.endpoints:
            if endpoint.prefix == names.TOPIC:
                info = found.setdefault(endpoint.topic, TopicInfo(endpoint.topic))
                info.endpoints.append(endpoint)
        return dict(sorted(found.items()))

    def topic(self, name: str) -> TopicInfo:
        """Return a topic by its fully qualified name; it may have no endpoints."""
        return self.topics().get(name, TopicInfo(name))

    def services(self) -> dict[str, str]:
        """Return names and types of all services that have a server."""
        return {
            e.topic: names.service_type_name(e.type_name)
            for e in sorted(self.endpoints, key=lambda e: e.topic)
            if e.prefix == names.REQUEST and e.endpoint_type is EndpointType.SUBSCRIPTION
        }

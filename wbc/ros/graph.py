"""The ROS graph: the other nodes, with their topics and services."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from wbc.ros import names
from wbc.ros.dds_endpoints import DdsReader, EndpointConfig, parse_user_data
from wbc.ros.discovery import TOPIC, NodeEntities
from wbc.ros.graph_snapshot import EndpointType, GraphSnapshot, TopicEndpointInfo
from wbc.ros.qos import DISCOVERY_INFO_OF_ALL, QoSProfile

if TYPE_CHECKING:
    from wbc.ros.node import Node

_SETTLED = 0.25  # s without a change after which discovery is taken as complete
_MAX_SAMPLES = 4096


class Graph:
    """Discovers the graph through a node; see `Node.graph`.

    Args:
        node: the node, which is not part of the graph that it discovers.

    Attributes:
        reader: DDS reader of the discovery messages.
    """

    def __init__(self, node: Node) -> None:
        from cyclonedds.builtin import (
            BuiltinDataReader,
            BuiltinTopicDcpsParticipant,
            BuiltinTopicDcpsPublication,
            BuiltinTopicDcpsSubscription,
        )

        self._node = node
        dds, form = node.participant.dds, node.participant.discovery_format
        self._participants = BuiltinDataReader(dds, BuiltinTopicDcpsParticipant)
        self._endpoints = {
            EndpointType.PUBLISHER: BuiltinDataReader(dds, BuiltinTopicDcpsPublication),
            EndpointType.SUBSCRIPTION: BuiltinDataReader(dds, BuiltinTopicDcpsSubscription),
        }
        config = EndpointConfig(TOPIC, form.dds_type(), DISCOVERY_INFO_OF_ALL, form.user_data())
        self.reader = DdsReader(dds, config)
        self._nodes: dict[bytes, tuple[NodeEntities, ...]] = {}  # by participant
        node.add_waitable(self)

    def execute(self) -> None:
        """Process the received discovery messages."""
        for data, _ in self.reader.take():
            try:
                participant, nodes = self._node.participant.discovery_format.decode(data)
            except ValueError:
                continue
            if participant != self._node.participant.guid:
                self._nodes[participant] = nodes

    def node_names(self) -> tuple[str, ...]:
        """Return the names of the other nodes, sorted; quicker than a snapshot."""
        return tuple(sorted(node.fully_qualified_name for node in self._alive_nodes()))

    def _alive_nodes(self) -> list[NodeEntities]:
        alive = {participant.key.bytes for participant in _alive(self._participants)}
        return [n for key, entities in self._nodes.items() if key in alive for n in entities]

    def snapshot(self) -> GraphSnapshot:
        """Return the graph as discovered so far; discovery goes on while the node spins."""
        nodes = self._alive_nodes()
        owners = {
            gid: node.fully_qualified_name
            for node in nodes
            for gid in (*node.readers, *node.writers)
        }
        endpoints = (
            _endpoint_info(endpoint_type, endpoint, owners)
            for endpoint_type, reader in self._endpoints.items()
            for endpoint in _alive(reader)
            if endpoint.participant_key.bytes != self._node.participant.guid
        )
        return GraphSnapshot(
            tuple(sorted(node.fully_qualified_name for node in nodes)),
            tuple(info for info in endpoints if info is not None),
        )

    def settle(self, min_sec: float = 0.5, max_sec: float = 3.0) -> GraphSnapshot:
        """Spin the node until discovery is complete; return the graph.

        Args:
            min_sec: minimum time, s.
            max_sec: maximum time, s.
        """
        start = changed = time.monotonic()
        previous: GraphSnapshot | None = None
        while True:
            self._node.spin_once(0.02)
            now = time.monotonic()
            snapshot = self.snapshot()
            if snapshot != previous:
                previous, changed = snapshot, now
            settled = now - start > min_sec and now - changed > _SETTLED
            if now - start > max_sec or (settled and self._is_complete()):
                return snapshot

    def wait_for(
        self, condition: Callable[[GraphSnapshot], bool], timeout_sec: float
    ) -> GraphSnapshot | None:
        """Spin the node until a condition on the graph holds.

        Args:
            condition: evaluated on one snapshot after the other.
            timeout_sec: time limit, s.

        Returns:
            The snapshot that fulfills the condition; None after the time limit.
        """
        snapshot: GraphSnapshot | None = None

        def fulfilled() -> bool:
            nonlocal snapshot
            snapshot = self.snapshot()
            return condition(snapshot)

        return snapshot if self._node.spin_until(fulfilled, timeout_sec) else None

    def _is_complete(self) -> bool:
        """Return whether all ROS 2 processes have announced nodes whose endpoints are all known."""
        known = {e.key.bytes for reader in self._endpoints.values() for e in _alive(reader)}
        return all(
            participant.key.bytes in self._nodes
            and all(
                known.issuperset((*node.readers, *node.writers))
                for node in self._nodes[participant.key.bytes]
            )
            for participant in _alive(self._participants)
            if participant.key.bytes != self._node.participant.guid
            and "enclave" in parse_user_data(participant.qos)
        )


def _alive(reader: Any) -> list[Any]:
    from cyclonedds.core import InstanceState

    samples = reader.read(_MAX_SAMPLES)
    return [s for s in samples if s.sample_info.instance_state == InstanceState.Alive]


def _endpoint_info(
    endpoint_type: EndpointType, endpoint: Any, owners: dict[bytes, str]
) -> TopicEndpointInfo | None:
    """Return an endpoint of a topic or service of ROS; None for any other endpoint."""
    parsed = names.parse_dds_topic_name(endpoint.topic_name)
    if parsed is None:
        return None
    prefix, topic = parsed
    gid = endpoint.key.bytes
    return TopicEndpointInfo(
        endpoint_type,
        topic,
        prefix,
        endpoint.type_name,
        owners.get(gid, ""),
        QoSProfile.from_dds(endpoint.qos),
        parse_user_data(endpoint.qos),
        gid,
    )

"""The ROS graph: the other nodes, with their topics and services."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from wbc.ros import names
from wbc.ros.dds_endpoints import DdsReader
from wbc.ros.discovery import TOPIC, NodeEntities
from wbc.ros.graph_snapshot import GraphSnapshot, TopicEndpointInfo
from wbc.ros.qos import (
    DISCOVERY_INFO_OF_ALL,
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
)

if TYPE_CHECKING:
    from wbc.ros.node import Node

_HASH = re.compile(r"typehash=(RIHS\d\d_[0-9a-f]{64})")
_SETTLED = 0.25  # s without a change after which discovery is taken as complete
_MAX_SAMPLES = 4096


class Graph:
    """Discovers the graph through a node; `Node.graph`.

    Args:
        node: the node, which is not part of the graph that it sees.

    Attributes:
        reader: DDS reader of the discovery messages.
    """

    has_pending = False

    def __init__(self, node: Node) -> None:
        from cyclonedds.builtin import (
            BuiltinDataReader,
            BuiltinTopicDcpsParticipant,
            BuiltinTopicDcpsPublication,
            BuiltinTopicDcpsSubscription,
        )

        self._node = node
        participant = node.participant
        self._participants = BuiltinDataReader(participant.dds, BuiltinTopicDcpsParticipant)
        self._publications = BuiltinDataReader(participant.dds, BuiltinTopicDcpsPublication)
        self._subscriptions = BuiltinDataReader(participant.dds, BuiltinTopicDcpsSubscription)
        form = participant.discovery_format
        self.reader = DdsReader(
            participant, TOPIC, form.dds_type(), DISCOVERY_INFO_OF_ALL, form.user_data()
        )
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

    def snapshot(self) -> GraphSnapshot:
        """Return the graph as discovered so far; discovery goes on while the node spins."""
        alive = {p.key.bytes for p in _alive(self._participants)}
        nodes = [n for who, several in self._nodes.items() if who in alive for n in several]
        owners = {
            gid: node.fully_qualified_name
            for node in nodes
            for gid in (*node.readers, *node.writers)
        }
        return GraphSnapshot(
            tuple(sorted(node.fully_qualified_name for node in nodes)),
            self._endpoints(self._publications, owners),
            self._endpoints(self._subscriptions, owners),
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
            quiet = now - start > min_sec and now - changed > _SETTLED
            if now - start > max_sec or (quiet and self._is_complete()):
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
        found: GraphSnapshot | None = None

        def fulfilled() -> bool:
            nonlocal found
            snapshot = self.snapshot()
            if condition(snapshot):
                found = snapshot
            return found is not None

        self._node.spin_until(fulfilled, timeout_sec)
        return found

    def _is_complete(self) -> bool:
        """Return whether all ROS 2 processes have announced nodes whose endpoints are all known."""
        endpoints = (*_alive(self._publications), *_alive(self._subscriptions))
        seen = {one.key.bytes for one in endpoints}
        return all(
            who in self._nodes
            and all(seen.issuperset((*e.readers, *e.writers)) for e in self._nodes[who])
            for one in _alive(self._participants)
            if (who := one.key.bytes) != self._node.participant.guid
            and "enclave=" in _user_data(one.qos)
        )

    def _endpoints(self, reader: Any, owners: dict[bytes, str]) -> tuple[TopicEndpointInfo, ...]:
        others = (
            one
            for one in _alive(reader)
            if one.participant_key.bytes != self._node.participant.guid
        )
        return tuple(e for one in others if (e := _endpoint(one, owners)) is not None)


def _alive(reader: Any) -> list[Any]:
    from cyclonedds.core import InstanceState

    return [
        one
        for one in reader.read(_MAX_SAMPLES)
        if one.sample_info.instance_state == InstanceState.Alive
    ]


def _endpoint(one: Any, owners: dict[bytes, str]) -> TopicEndpointInfo | None:
    known = names.parse_dds_topic_name(one.topic_name)
    if known is None:
        return None
    prefix, topic = known
    user_data = _user_data(one.qos)
    hashed = _HASH.search(user_data)
    gid = one.key.bytes
    return TopicEndpointInfo(
        topic,
        prefix,
        names.ros_type_name(one.type_name),
        one.type_name,
        owners.get(gid, ""),
        _qos_profile(one.qos),
        hashed[1] if hashed else "",
        user_data,
        gid,
    )


def _user_data(qos: Any) -> str:
    from cyclonedds.core import Policy

    data: bytes = qos[Policy.Userdata].data if Policy.Userdata in qos else b""
    return data.decode("utf-8", "replace")


def _qos_profile(qos: Any) -> QoSProfile:
    """Return the discovered quality of service; not every DDS implementation tells the depth."""
    from cyclonedds.core import Policy

    history = qos[Policy.History] if Policy.History in qos else None  # noqa: SIM401  it has no get
    depth = getattr(history, "depth", 0)
    reliable = (
        Policy.Reliability in qos and qos[Policy.Reliability] != Policy.Reliability.BestEffort
    )
    volatile = Policy.Durability not in qos or qos[Policy.Durability] == Policy.Durability.Volatile
    lifespan = qos[Policy.Lifespan].lifespan if Policy.Lifespan in qos else None
    return QoSProfile(
        depth,
        ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        DurabilityPolicy.VOLATILE if volatile else DurabilityPolicy.TRANSIENT_LOCAL,
        HistoryPolicy.KEEP_LAST if depth else HistoryPolicy.KEEP_ALL,
        None if lifespan is None or lifespan > 1 << 62 else 1e-9 * lifespan,
    )

"""The graph: which nodes and topics there are, and who talks to whom."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from wbc.ros import names
from wbc.ros.discovery import TOPIC, NodeEntry
from wbc.ros.endpoints import Reader
from wbc.ros.node import Node
from wbc.ros.qos import DISCOVERY_INFO_OF_ALL, Qos

_HASH = re.compile(r"typehash=(RIHS\d\d_[0-9a-f]{64})")
_SETTLED = 0.25  # s without news: then it is taken as complete
_MANY = 4096


@dataclass(frozen=True)
class Endpoint:
    """A publisher or subscription of some node.

    Attributes:
        topic: its ROS name.
        kind: "rt" for a topic, "rq" and "rr" for a service's requests and replies.
        type_name: `pkg/msg/Name`.
        dds_type: its name in DDS.
        node: full name of its node; empty when that is not known.
        qos: quality of service.
        type_hash: `RIHS01_…`; empty when it does not tell.
        user_data: what it tells about itself.
        gid: its 16-byte id.
    """

    topic: str
    kind: str
    type_name: str
    dds_type: str
    node: str
    qos: Qos
    type_hash: str
    user_data: str
    gid: bytes


@dataclass
class Topic:
    """A topic.

    Attributes:
        name: its full name.
        publishers: who writes.
        subscriptions: who reads.
    """

    name: str
    publishers: list[Endpoint] = field(default_factory=list)
    subscriptions: list[Endpoint] = field(default_factory=list)

    @property
    def types(self) -> list[str]:
        """Its type; more than one if they disagree."""
        return sorted({e.type_name for e in (*self.publishers, *self.subscriptions)})

    @property
    def dds_type(self) -> str:
        """Its type's name in DDS."""
        return next(e.dds_type for e in (*self.publishers, *self.subscriptions))


@dataclass(frozen=True)
class GraphState:
    """The graph at one instant.

    Attributes:
        nodes: full names of all nodes, sorted; a name may occur twice.
        publishers: all that are part of ROS.
        subscriptions: likewise.
    """

    nodes: tuple[str, ...]
    publishers: tuple[Endpoint, ...]
    subscriptions: tuple[Endpoint, ...]

    @property
    def endpoints(self) -> tuple[Endpoint, ...]:
        """Publishers, then subscriptions."""
        return self.publishers + self.subscriptions

    def topics(self) -> dict[str, Topic]:
        """All topics by name, without those that services are made of."""
        found: dict[str, Topic] = {}
        for endpoint in self.publishers:
            if endpoint.kind == names.TOPIC:
                name = endpoint.topic
                found.setdefault(name, Topic(name)).publishers.append(endpoint)
        for endpoint in self.subscriptions:
            if endpoint.kind == names.TOPIC:
                name = endpoint.topic
                found.setdefault(name, Topic(name)).subscriptions.append(endpoint)
        return dict(sorted(found.items()))

    def services(self) -> dict[str, str]:
        """Name and type of all services that somebody serves."""
        return {
            e.topic: names.service_type(e.type_name)
            for e in sorted(self.subscriptions, key=lambda e: e.topic)
            if e.kind == names.REQUEST
        }


class Graph:
    """Looks at the graph through a node.

    Args:
        node: it is not part of what is seen.
    """

    impatient = False

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
        dialect = participant.dialect
        self.reader = Reader(
            participant, TOPIC, dialect.dds_type(), DISCOVERY_INFO_OF_ALL, dialect.user_data()
        )
        self._entries: dict[bytes, tuple[NodeEntry, ...]] = {}
        node.attend(self)

    def work(self) -> None:
        """Take in which nodes there are."""
        for data, _ in self.reader.take():
            try:
                participant, entries = self._node.participant.dialect.decode(data)
            except ValueError:
                continue
            if participant != self._node.participant.guid:
                self._entries[participant] = entries

    def state(self) -> GraphState:
        """What is known now; more comes in while the node spins."""
        alive = {p.key.bytes for p in _alive(self._participants)}
        entries = [e for who, several in self._entries.items() if who in alive for e in several]
        owners = {
            gid: entry.full_name for entry in entries for gid in (*entry.readers, *entry.writers)
        }
        return GraphState(
            tuple(sorted(entry.full_name for entry in entries)),
            self._endpoints(self._publications, owners),
            self._endpoints(self._subscriptions, owners),
        )

    def settle(self, least: float = 0.5, most: float = 3.0) -> GraphState:
        """Wait until everybody has told about itself and no more news come.

        Args:
            least: s to wait at least.
            most: s to wait at most.

        Returns:
            What is known then.
        """
        start = changed = time.monotonic()
        seen: GraphState | None = None
        while True:
            self._node.spin_once(0.02)
            now = time.monotonic()
            state = self.state()
            if state != seen:
                seen, changed = state, now
            quiet = now - start > least and now - changed > _SETTLED
            if now - start > most or (quiet and self._all_told()):
                return state

    def wait_for(
        self, condition: Callable[[GraphState], bool], timeout: float
    ) -> GraphState | None:
        """Wait until something is true of the graph.

        Args:
            condition: asked of one state after the other.
            timeout: s.

        Returns:
            The state of which it is true; None when there was none in time.
        """
        found: GraphState | None = None

        def fulfilled() -> bool:
            nonlocal found
            state = self.state()
            if condition(state):
                found = state
            return found is not None

        self._node.spin(fulfilled, timeout)
        return found

    def _all_told(self) -> bool:
        """Whether each process of ROS 2 has told its nodes, and all that these have is seen."""
        endpoints = (*_alive(self._publications), *_alive(self._subscriptions))
        seen = {one.key.bytes for one in endpoints}
        return all(
            who in self._entries
            and all(seen.issuperset((*e.readers, *e.writers)) for e in self._entries[who])
            for one in _alive(self._participants)
            if (who := one.key.bytes) != self._node.participant.guid
            and "enclave=" in _user_data(one.qos)
        )

    def _endpoints(self, reader: Any, owners: dict[bytes, str]) -> tuple[Endpoint, ...]:
        others = (
            one
            for one in _alive(reader)
            if one.participant_key.bytes != self._node.participant.guid
        )
        return tuple(e for one in others if (e := _endpoint(one, owners)) is not None)


def _alive(reader: Any) -> list[Any]:
    from cyclonedds.core import InstanceState

    return [
        one for one in reader.read(_MANY) if one.sample_info.instance_state == InstanceState.Alive
    ]


def _endpoint(one: Any, owners: dict[bytes, str]) -> Endpoint | None:
    known = names.ros_topic(one.topic_name)
    if known is None:
        return None
    kind, topic = known
    user_data = _user_data(one.qos)
    hashed = _HASH.search(user_data)
    gid = one.key.bytes
    return Endpoint(
        topic,
        kind,
        names.ros_type(one.type_name),
        one.type_name,
        owners.get(gid, ""),
        qos_of(one.qos),
        hashed[1] if hashed else "",
        user_data,
        gid,
    )


def _user_data(qos: Any) -> str:
    from cyclonedds.core import Policy

    data: bytes = qos[Policy.Userdata].data if Policy.Userdata in qos else b""
    return data.decode("utf-8", "replace")


def qos_of(qos: Any) -> Qos:
    """A quality of service as discovered; the depth is not told by every implementation."""
    from cyclonedds.core import Policy

    history = qos[Policy.History] if Policy.History in qos else None  # noqa: SIM401  it has no get
    lifespan = qos[Policy.Lifespan].lifespan if Policy.Lifespan in qos else None
    return Qos(
        depth=getattr(history, "depth", 0),
        reliable=Policy.Reliability in qos
        and qos[Policy.Reliability] != Policy.Reliability.BestEffort,
        latched=Policy.Durability in qos and qos[Policy.Durability] != Policy.Durability.Volatile,
        lifespan=None if lifespan is None or lifespan > 1 << 62 else 1e-9 * lifespan,
    )

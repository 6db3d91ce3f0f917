"""The DDS participant of a node, and the announcement of the node's endpoints."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from wbc.ros.dds_endpoints import DdsWriter
from wbc.ros.dds_types import import_cyclonedds
from wbc.ros.discovery import TOPIC, DiscoveryFormat, NodeEntities
from wbc.ros.network import Network
from wbc.ros.qos import DISCOVERY_INFO


class Participant:
    """The DDS participant of one node.

    Args:
        namespace: namespace of the node.
        name: name of the node.
        network: where the node looks for others.

    Attributes:
        dds: the domain participant of Cyclone DDS.
        guid: 16-byte id.
        discovery_format: format of the discovery message.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the domain cannot be joined.
    """

    def __init__(self, namespace: str, name: str, network: Network) -> None:
        import_cyclonedds()
        from cyclonedds.core import Policy
        from cyclonedds.core import Qos as DdsQos
        from cyclonedds.domain import DomainParticipant

        self._domain = network.join()
        self.dds: Any = DomainParticipant(
            network.domain_id, qos=DdsQos(Policy.Userdata(b"enclave=/;"))
        )
        self.guid: bytes = self.dds.guid.bytes
        self.discovery_format = form = DiscoveryFormat.from_environment()
        self._entities = NodeEntities(namespace, name)
        self._writer = DdsWriter(self, TOPIC, form.dds_type(), DISCOVERY_INFO, form.user_data())
        self._announce()

    def add(self, readers: tuple[bytes, ...] = (), writers: tuple[bytes, ...] = ()) -> None:
        """Announce that the node has these endpoints, given by their 16-byte ids."""
        old = self._entities
        self._entities = replace(old, readers=old.readers + readers, writers=old.writers + writers)
        self._announce()

    def remove(self, *gids: bytes) -> None:
        """Announce that the node no longer has these endpoints."""
        old = self._entities
        self._entities = replace(
            old,
            readers=tuple(gid for gid in old.readers if gid not in gids),
            writers=tuple(gid for gid in old.writers if gid not in gids),
        )
        self._announce()

    def _announce(self) -> None:
        self._writer.write(self.discovery_format.encode(self.guid, (self._entities,)))

    def leave(self) -> None:
        """Leave the domain with all endpoints; the others are notified at once."""
        # The package deletes entities in `__del__` only, whose time is not defined.
        self.dds.__del__()

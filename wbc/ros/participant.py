"""The DDS participant of a node, and the announcement of the node's endpoints."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from wbc.ros.dds_endpoints import DdsReader, DdsWriter, EndpointConfig
from wbc.ros.dds_types import import_cyclonedds
from wbc.ros.discovery import TOPIC, DiscoveryFormat, NodeEntities
from wbc.ros.network import Network
from wbc.ros.qos import LATCHED


class Participant:
    """The DDS participant of one node, which announces the node's readers and writers.

    Args:
        namespace: namespace of the node.
        name: name of the node.
        network: DDS domain and network interface.

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
        self._writers: list[DdsWriter] = []  # Cyclone DDS removes writers without a reference
        config = EndpointConfig(TOPIC, form.dds_type(), LATCHED, form.user_data())
        self._discovery = DdsWriter(self.dds, config)
        self._announce(NodeEntities(namespace, name))

    def create_writer(self, config: EndpointConfig) -> DdsWriter:
        """Create a writer that belongs to the node."""
        writer = DdsWriter(self.dds, config)
        self._writers.append(writer)
        self._announce(replace(self._entities, writers=(*self._entities.writers, writer.gid)))
        return writer

    def create_reader(self, config: EndpointConfig) -> DdsReader:
        """Create a reader that belongs to the node."""
        reader = DdsReader(self.dds, config)
        self._announce(replace(self._entities, readers=(*self._entities.readers, reader.gid)))
        return reader

    def destroy_reader(self, reader: DdsReader) -> None:
        """Remove a reader of the node."""
        readers = tuple(gid for gid in self._entities.readers if gid != reader.gid)
        self._announce(replace(self._entities, readers=readers))
        reader.close()

    def _announce(self, entities: NodeEntities) -> None:
        self._entities = entities
        self._discovery.write(self.discovery_format.encode(self.guid, (entities,)))

    def leave(self) -> None:
        """Leave the domain with all endpoints; the others are notified at once."""
        # The package deletes entities in `__del__` only, whose time is not defined.
        self.dds.__del__()

"""A process's place in a DDS domain, and the news of which node is in it."""

from __future__ import annotations

from typing import Any

from wbc.ros.discovery import TOPIC, Dialect, NodeEntry
from wbc.ros.endpoints import Writer
from wbc.ros.network import Network
from wbc.ros.qos import DISCOVERY_INFO
from wbc.ros.wire import import_cyclonedds


class Participant:
    """One node's entrance to DDS.

    Args:
        space: the node's namespace.
        name: the node's name.
        network: where it looks for others.

    Attributes:
        dds: Cyclone's own participant.
        guid: its 16-byte id.
        dialect: of the discovery message.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the domain cannot be joined.
    """

    def __init__(self, space: str, name: str, network: Network) -> None:
        import_cyclonedds()
        from cyclonedds.core import Policy
        from cyclonedds.core import Qos as DdsQos
        from cyclonedds.domain import DomainParticipant

        self._domain = network.join()
        self.dds: Any = DomainParticipant(
            network.domain, qos=DdsQos(Policy.Userdata(b"enclave=/;"))
        )
        self.guid: bytes = self.dds.guid.bytes
        self.dialect = Dialect.of()
        self._entry = NodeEntry(space, name)
        self._news = Writer(
            self, TOPIC, self.dialect.dds_type(), DISCOVERY_INFO, self.dialect.user_data()
        )
        self._announce()

    def add(self, readers: tuple[bytes, ...] = (), writers: tuple[bytes, ...] = ()) -> None:
        """Tell the world that the node has these endpoints."""
        entry = self._entry
        self._entry = NodeEntry(
            entry.space, entry.name, entry.readers + readers, entry.writers + writers
        )
        self._announce()

    def remove(self, *gids: bytes) -> None:
        """Tell the world that the node has these endpoints no longer."""
        entry = self._entry
        self._entry = NodeEntry(
            entry.space,
            entry.name,
            tuple(gid for gid in entry.readers if gid not in gids),
            tuple(gid for gid in entry.writers if gid not in gids),
        )
        self._announce()

    def _announce(self) -> None:
        self._news.write(self.dialect.encode(self.guid, (self._entry,)))

    def leave(self) -> None:
        """Leave the domain, with all endpoints; the others get to know at once."""
        self.dds.__del__()  # now rather than some time, for which the package has no other way

"""The message that assigns DDS endpoints to nodes.

DDS discovers writers and readers; `rmw_dds_common/ParticipantEntitiesInfo`, published on
`ros_discovery_info`, assigns them to nodes. An id of an endpoint takes 24 bytes in this message up
to Humble, and 16 bytes from Iron on.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from wbc.messages import message_type, typestore
from wbc.ros.dds_types import dds_type, raw_dds_type

TOPIC = "ros_discovery_info"
TYPE = "rmw_dds_common/msg/ParticipantEntitiesInfo"
_GID, _LONG_GID = 16, 24  # bytes
_WITH_LONG_GID = ("dashing", "eloquent", "foxy", "galactic", "humble")


@dataclass(frozen=True)
class NodeEntities:
    """A node and its endpoints (`rmw_dds_common/msg/NodeEntitiesInfo`).

    Attributes:
        namespace: namespace of the node.
        name: name of the node.
        readers: 16-byte ids of its readers: subscriptions, service servers and clients.
        writers: 16-byte ids of its writers.
    """

    namespace: str
    name: str
    readers: tuple[bytes, ...] = ()
    writers: tuple[bytes, ...] = ()

    @property
    def fully_qualified_name(self) -> str:
        """Namespace and name."""
        return f"{self.namespace.rstrip('/')}/{self.name}"


@dataclass(frozen=True)
class DiscoveryFormat:
    """Binary format of the discovery message.

    Attributes:
        gid_size: size of an endpoint id, bytes.
    """

    gid_size: int

    @staticmethod
    def from_environment(environment: Mapping[str, str] | None = None) -> DiscoveryFormat:
        """Return the format of the distribution named by `ROS_DISTRO`; by default the current one.

        Args:
            environment: the variables; `os.environ` by default.
        """
        environment = os.environ if environment is None else environment
        old = environment.get("ROS_DISTRO", "").lower() in _WITH_LONG_GID
        return DiscoveryFormat(_LONG_GID if old else _GID)

    def dds_type(self) -> Any:
        """Return the DDS type of the message."""
        message = message_type(TYPE)
        return dds_type(TYPE) if self.gid_size == _GID else raw_dds_type(message.dds_name())

    def user_data(self) -> str:
        """Return the USER_DATA of the endpoints: the type hash, introduced with the shorter ids."""
        return f"typehash={message_type(TYPE).type_hash()};" if self.gid_size == _GID else ""

    def encode(self, participant: bytes, nodes: tuple[NodeEntities, ...]) -> bytes:
        """Return the serialized message."""
        types: Any = self._typestore.types

        def gid(data: bytes) -> Any:
            padded = data.ljust(self.gid_size, b"\0")
            return types["rmw_dds_common/msg/Gid"](data=np.frombuffer(padded, np.uint8))

        entities = [
            types["rmw_dds_common/msg/NodeEntitiesInfo"](
                node_namespace=node.namespace,
                node_name=node.name,
                reader_gid_seq=[gid(reader) for reader in node.readers],
                writer_gid_seq=[gid(writer) for writer in node.writers],
            )
            for node in nodes
        ]
        message = types[TYPE](gid=gid(participant), node_entities_info_seq=entities)
        return bytes(self._typestore.serialize_cdr(message, TYPE, little_endian=True))

    def decode(self, data: bytes) -> tuple[bytes, tuple[NodeEntities, ...]]:
        """Return the participant's 16-byte id and its nodes.

        Raises:
            ValueError: the bytes are not a discovery message.
        """
        from rosbags.serde import SerdeError

        try:
            message = self._typestore.deserialize_cdr(data, TYPE)
        except SerdeError as error:
            raise ValueError(f"the bytes are not a discovery message: {error}") from error

        def gids(sequence: Any) -> tuple[bytes, ...]:
            return tuple(bytes(gid.data)[:_GID] for gid in sequence)

        return bytes(message.gid.data)[:_GID], tuple(
            NodeEntities(
                info.node_namespace,
                info.node_name,
                gids(info.reader_gid_seq),
                gids(info.writer_gid_seq),
            )
            for info in message.node_entities_info_seq
        )

    @cached_property
    def _typestore(self) -> Any:
        from rosbags.typesys import Stores, get_typestore

        if self.gid_size == _LONG_GID:
            return get_typestore(Stores.ROS2_HUMBLE)
        message_type(TYPE)  # registers the class with the typestore
        return typestore()

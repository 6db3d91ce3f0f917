"""The message that assigns DDS endpoints to nodes.

DDS discovers writers and readers; `rmw_dds_common/ParticipantEntitiesInfo`, published on
`ros_discovery_info`, says which node they belong to. An endpoint id takes 24 bytes in it up to
Humble, and 16 bytes from Iron on.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from wbc.messages import message_type
from wbc.ros.dds_types import carry_bytes

TOPIC = "ros_discovery_info"
TYPE = "rmw_dds_common/msg/ParticipantEntitiesInfo"
_HEADER = b"\x00\x01\x00\x00"
_WORD = struct.Struct("<I")
_GUID = 16  # bytes
_LONG_GID, _GID = 24, 16  # bytes
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
        return _dds_type(self.gid_size)

    def user_data(self) -> str:
        """Return the USER_DATA of the endpoints: the type hash, introduced with the shorter ids."""
        return "" if self.gid_size == _LONG_GID else f"typehash={message_type(TYPE).type_hash()};"

    def encode(self, participant: bytes, nodes: tuple[NodeEntities, ...]) -> bytes:
        """Return the serialized message."""
        out = bytearray(_HEADER + self._gid(participant) + _WORD.pack(len(nodes)))
        for node in nodes:
            _write_text(out, node.namespace)
            _write_text(out, node.name)
            for gids in (node.readers, node.writers):
                _align(out)
                out += _WORD.pack(len(gids)) + b"".join(map(self._gid, gids))
        return bytes(out)

    def decode(self, data: bytes) -> tuple[bytes, tuple[NodeEntities, ...]]:
        """Return the participant's 16-byte id and its nodes.

        Raises:
            ValueError: the bytes are not a discovery message.
        """
        reader = _DiscoveryReader(data, self.gid_size)
        participant = reader.gid()
        nodes = []
        for _ in range(reader.word()):
            namespace, name = reader.text(), reader.text()
            readers = tuple(reader.gid() for _ in range(reader.word()))
            writers = tuple(reader.gid() for _ in range(reader.word()))
            nodes.append(NodeEntities(namespace, name, readers, writers))
        return participant, tuple(nodes)

    def _gid(self, gid: bytes) -> bytes:
        return gid.ljust(self.gid_size, b"\0")


def _align(out: bytearray) -> None:
    out += bytes(-len(out) % 4)


def _write_text(out: bytearray, text: str) -> None:
    data = text.encode() + b"\0"
    _align(out)
    out += _WORD.pack(len(data)) + data


class _DiscoveryReader:
    def __init__(self, data: bytes, gid_size: int) -> None:
        self._data, self._at, self._gid_size = data, len(_HEADER), gid_size

    def take(self, size: int) -> bytes:
        part = self._data[self._at : self._at + size]
        if len(part) < size:
            raise ValueError(f"{size} bytes expected at offset {self._at} of {len(self._data)}")
        self._at += size
        return part

    def word(self) -> int:
        self._at += -self._at % 4
        return int(_WORD.unpack(self.take(4))[0])

    def text(self) -> str:
        return self.take(self.word()).rstrip(b"\0").decode("utf-8", "replace")

    def gid(self) -> bytes:
        return self.take(self._gid_size)[:_GUID]


@cache
def _dds_type(gid_size: int) -> Any:
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.types import array, bounded_str, sequence, uint8

    def structure(name: str, fields: dict[str, Any]) -> Any:
        full = f"rmw_dds_common.msg.dds_.{name}_"
        return make_idl_struct(f"{name}_", full, fields, dataclassify=False)

    gid = structure("Gid", {"data": array[uint8, gid_size]})
    node = structure(
        "NodeEntitiesInfo",
        {
            "node_namespace": bounded_str[256],
            "node_name": bounded_str[256],
            "reader_gid_seq": sequence[gid],
            "writer_gid_seq": sequence[gid],
        },
    )
    return carry_bytes(
        structure("ParticipantEntitiesInfo", {"gid": gid, "node_entities_info_seq": sequence[node]})
    )

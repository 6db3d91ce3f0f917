"""Who is in a process: the message by which ROS 2 systems learn the names of nodes.

DDS tells which writers and readers there are; `rmw_dds_common/ParticipantEntitiesInfo`, on the
topic `ros_discovery_info`, tells which node has which. Up to Humble an id took 24 bytes in it,
from Iron on it takes 16.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from wbc.messages import type_hash
from wbc.ros.wire import opaque

TOPIC = "ros_discovery_info"
TYPE = "rmw_dds_common/msg/ParticipantEntitiesInfo"
_HEADER = b"\x00\x01\x00\x00"
_WORD = struct.Struct("<I")
_GUID = 16  # bytes
_LONG_GID, _GID = 24, 16
_WITH_LONG_GID = ("dashing", "eloquent", "foxy", "galactic", "humble")


@dataclass(frozen=True)
class NodeEntry:
    """A node and its endpoints.

    Attributes:
        space: its namespace.
        name: its name.
        readers: 16-byte ids of its subscriptions, and of what serves and calls services.
        writers: likewise.
    """

    space: str
    name: str
    readers: tuple[bytes, ...] = ()
    writers: tuple[bytes, ...] = ()

    @property
    def full_name(self) -> str:
        """Namespace and name."""
        return f"{self.space.rstrip('/')}/{self.name}"


@dataclass(frozen=True)
class Dialect:
    """The form of the message, which changed once.

    Attributes:
        gid_size: bytes of an id.
    """

    gid_size: int

    @staticmethod
    def of(environment: Mapping[str, str] | None = None) -> Dialect:
        """The form that the distribution named by `ROS_DISTRO` has; without it, today's."""
        environment = os.environ if environment is None else environment
        old = environment.get("ROS_DISTRO", "").lower() in _WITH_LONG_GID
        return Dialect(_LONG_GID if old else _GID)

    def dds_type(self) -> Any:
        """The message's type for DDS."""
        return _dds_type(self.gid_size)

    def user_data(self) -> str:
        """What its endpoints tell: the type's hash, which came with the shorter ids."""
        return "" if self.gid_size == _LONG_GID else f"typehash={type_hash(TYPE)};"

    def encode(self, participant: bytes, nodes: tuple[NodeEntry, ...]) -> bytes:
        """The message's bytes."""
        out = bytearray(_HEADER + self._gid(participant) + _WORD.pack(len(nodes)))
        for node in nodes:
            _write_text(out, node.space)
            _write_text(out, node.name)
            for gids in (node.readers, node.writers):
                _align(out)
                out += _WORD.pack(len(gids)) + b"".join(map(self._gid, gids))
        return bytes(out)

    def decode(self, data: bytes) -> tuple[bytes, tuple[NodeEntry, ...]]:
        """Participant and its nodes.

        Raises:
            ValueError: the bytes are no such message.
        """
        source = _Source(data, self.gid_size)
        participant = source.gid()
        nodes = []
        for _ in range(source.word()):
            space, name = source.text(), source.text()
            readers = tuple(source.gid() for _ in range(source.word()))
            writers = tuple(source.gid() for _ in range(source.word()))
            nodes.append(NodeEntry(space, name, readers, writers))
        return participant, tuple(nodes)

    def _gid(self, gid: bytes) -> bytes:
        return gid.ljust(self.gid_size, b"\0")


def _align(out: bytearray) -> None:
    out += bytes(-len(out) % 4)


def _write_text(out: bytearray, text: str) -> None:
    data = text.encode() + b"\0"
    _align(out)
    out += _WORD.pack(len(data)) + data


class _Source:
    def __init__(self, data: bytes, gid_size: int) -> None:
        self._data, self._at, self._gid_size = data, len(_HEADER), gid_size

    def take(self, size: int) -> bytes:
        part = self._data[self._at : self._at + size]
        if len(part) < size:
            raise ValueError(f"{size} bytes are due at {self._at} of {len(self._data)}")
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
    return opaque(
        structure("ParticipantEntitiesInfo", {"gid": gid, "node_entities_info_seq": sequence[node]})
    )

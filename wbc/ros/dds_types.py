"""DDS types of ROS messages, with samples that carry serialized bytes.

DDS is given the true structure of each type, so that it refuses bytes that are no message of the
type; but `wbc.messages` encodes and decodes the bytes.
"""

from __future__ import annotations

import struct
from functools import cache
from typing import TYPE_CHECKING, Any

from wbc.errors import MissingExtra
from wbc.messages import message_type, typestore

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc

_HEADER = struct.Struct("<Qq")
_CDR_HEADER = 4  # bytes


def import_cyclonedds() -> Any:
    """Return the `cyclonedds` package.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
    """
    try:
        import cyclonedds
    except ImportError as error:
        raise MissingExtra("cyclonedds", "ros2") from error
    return cyclonedds


def _serialize(self: Any, *_: object, **__: object) -> bytes:
    return bytes(self.data)


def _deserialize(cls: Any, data: bytes, /, *_: object, **__: object) -> Any:
    sample = cls()
    sample.data = data
    return sample


@cache
def dds_type(name: str) -> Any:
    """Return the sample class of a message type.

    Args:
        name: `pkg/msg/Name`, or the part of an action that is sent on a topic.

    Raises:
        MessageError: there is no such type.
    """
    return struct_of_bytes(_structure(name, {}))


@cache
def dds_service_type(name: str) -> Any:
    """Return the sample class of a service's requests or replies, with the correlation header.

    Args:
        name: `pkg/srv/Name_Request` or `pkg/srv/Name_Response`.

    Raises:
        MessageError: there is no such type.
    """
    from cyclonedds.idl.types import int64, uint64

    # What `rmw_cyclonedds` puts before a request or reply: the client and its sequence number.
    header = {"client_guid": uint64, "sequence_number": int64}
    return struct_of_bytes(_structure(name, header))


@cache
def raw_dds_type(dds_name: str) -> Any:
    """Return a sample class for a type whose definition is not known.

    DDS takes the type for a structure of one byte and ignores the bytes that follow.

    Args:
        dds_name: DDS name of the type, for example `std_msgs::msg::dds_::String_`.
    """
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.types import uint8

    full = dds_name.replace("::", ".")
    fields = {"first": uint8}
    structure = make_idl_struct(full.rpartition(".")[2], full, fields, dataclassify=False)
    return struct_of_bytes(structure)


@cache
def _nested_type(name: str) -> Any:
    return _structure(name, {})


def _structure(name: str, header: dict[str, Any]) -> Any:
    from cyclonedds.idl import make_idl_struct

    package, kind, short = message_type(name).type_name.split("/")
    fields = {field: _type(desc) for field, desc in typestore().fielddefs[name][1]}
    return make_idl_struct(
        f"{short}_", f"{package}.{kind}.dds_.{short}_", {**header, **fields}, dataclassify=False
    )


def struct_of_bytes(structure: Any) -> Any:
    """Make the samples of a structure carry only `data`, the serialized bytes; return it.

    The methods are not inherited, because DDS would take a base class for a part of the structure.
    """
    structure.serialize = _serialize
    structure.deserialize = structure.deserialize_key = classmethod(_deserialize)
    return structure


def _type(desc: FieldDesc) -> Any:
    from cyclonedds.idl import types
    from rosbags.interfaces import Nodetype

    match desc:
        case Nodetype.NAME, name:
            return _nested_type(name)
        case Nodetype.BASE, ("string", limit):
            return types.bounded_str[limit] if limit else str
        case Nodetype.BASE, ("bool", _):
            return bool
        case Nodetype.BASE, (primitive, _):
            return getattr(types, {"byte": "uint8", "char": "uint8"}.get(primitive, primitive))
        case Nodetype.ARRAY, (element, size):
            return types.array[_type(element), size]
        case Nodetype.SEQUENCE, (element, size):
            return types.sequence[_type(element), size] if size else types.sequence[_type(element)]
    raise AssertionError(f"a field of an unknown kind: {desc}")


def with_header(data: bytes, client: int, number: int) -> bytes:
    """Insert the correlation header into a serialized request or reply.

    The 16 bytes of the header preserve every alignment.

    Args:
        data: serialized request or reply.
        client: handle of the client's writer.
        number: sequence number of the request.
    """
    return data[:_CDR_HEADER] + _HEADER.pack(client, number) + data[_CDR_HEADER:]


def without_header(data: bytes) -> tuple[int, int, bytes]:
    """Split a serialized request or reply into client, sequence number and message bytes.

    Raises:
        struct.error: there are too few bytes.
    """
    client, number = _HEADER.unpack_from(data, _CDR_HEADER)
    return client, number, data[:_CDR_HEADER] + data[_CDR_HEADER + _HEADER.size :]

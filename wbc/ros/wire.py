"""Message types as DDS knows them, whose samples are bytes that are made elsewhere.

DDS gets each type's true structure, so that it refuses what is no message of that type before
anyone reads it; but the bytes are written and read by `wbc.messages`.
"""

from __future__ import annotations

import struct
from functools import cache
from typing import Any

from wbc.errors import MissingExtra
from wbc.messages import definition
from wbc.messages.definition import Field, Shape

#: What `rmw_cyclonedds` puts before a request or reply: who asked, and which of its questions.
HEADER_FIELDS = (Field("client_guid", "uint64"), Field("sequence_number", "int64"))
_HEADER = struct.Struct("<Qq")
_CDR_HEADER = 4  # bytes


def import_cyclonedds() -> Any:
    """The `cyclonedds` package.

    Raises:
        MissingExtra: it is not installed.
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
    """The class of a message type's samples.

    Args:
        name: `pkg/msg/Name`, or a part of an action that is sent on a topic.

    Raises:
        MessageError: there is no such type.
    """
    return opaque(_structure(name, ()))


@cache
def dds_service_type(name: str) -> Any:
    """The class of the samples of a service's requests or replies, correlation included.

    Args:
        name: `pkg/srv/Name_Request` and the like.

    Raises:
        MessageError: there is no such type.
    """
    return opaque(_structure(name, HEADER_FIELDS))


@cache
def unread_type(dds_name: str) -> Any:
    """The class of the samples of any type, whose bytes are taken as they are.

    DDS takes it for a structure of one byte, and what follows for nothing.

    Args:
        dds_name: of the type, e.g. `std_msgs::msg::dds_::String_`.
    """
    import_cyclonedds()
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.types import uint8

    full = dds_name.replace("::", ".")
    fields = {"first": uint8}
    return opaque(make_idl_struct(full.rpartition(".")[2], full, fields, dataclassify=False))


@cache
def _nested_type(name: str) -> Any:
    return _structure(name, ())


def _structure(name: str, before: tuple[Field, ...]) -> Any:
    import_cyclonedds()
    from cyclonedds.idl import make_idl_struct

    package, kind, short = name.split("/")
    return make_idl_struct(
        f"{short}_",
        f"{package}.{kind}.dds_.{short}_",
        {field.name: _type(field) for field in (*before, *definition(name).fields)},
        dataclassify=False,
    )


def opaque(structure: Any) -> Any:
    """The class, with samples that have nothing but `data`, the bytes on the wire.

    A base class would do, but DDS would take it for a part of the structure.
    """
    structure.serialize = _serialize
    structure.deserialize = structure.deserialize_key = classmethod(_deserialize)
    return structure


def _type(field: Field) -> Any:
    from cyclonedds.idl import types

    element: Any
    if field.nested:
        element = _nested_type(field.type)
    elif field.type == "string":
        element = types.bounded_str[field.bound] if field.bound else str
    elif field.type == "bool":
        element = bool
    else:
        element = getattr(types, {"byte": "uint8", "char": "uint8"}.get(field.type, field.type))
    if field.shape is Shape.ARRAY:
        return types.array[element, field.size]
    if field.shape is Shape.BOUNDED:
        return types.sequence[element, field.size]
    return types.sequence[element] if field.shape is Shape.SEQUENCE else element


def with_header(data: bytes, client: int, number: int) -> bytes:
    """A request's or reply's bytes, with who asked (its writer's handle) and which question.

    The header's 16 bytes keep every alignment as it was.
    """
    return data[:_CDR_HEADER] + _HEADER.pack(client, number) + data[_CDR_HEADER:]


def without_header(data: bytes) -> tuple[int, int, bytes]:
    """Client, question and the message's own bytes.

    Raises:
        struct.error: there are too few bytes.
    """
    client, number = _HEADER.unpack_from(data, _CDR_HEADER)
    return client, number, data[:_CDR_HEADER] + data[_CDR_HEADER + _HEADER.size :]

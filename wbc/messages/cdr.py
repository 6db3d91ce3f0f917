"""CDR serialization of messages, as sent over DDS and written to logs: OMG's plain XCDR version 1.

A header of four bytes (`00 01 00 00`: little-endian) precedes the fields. Each number is aligned
to its own size, counted from the end of the header. A string is its length including the
terminating zero (uint32), its UTF-8 bytes and the zero; a sequence is its length (uint32) and its
elements.

Source: OMG DDS-XTypes 1.3, §7.4; OMG CORBA 3.3, part 2, §9.3.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from wbc.messages.definition import PRIMITIVES, Field, MessageDefinition, Multiplicity
from wbc.messages.errors import MessageError
from wbc.messages.registry import get_definition

HEADER = b"\x00\x01\x00\x00"
_HEADER_BIG_ENDIAN = b"\x00\x00"
_LITTLE_ENDIAN = b"\x00\x01"
_LENGTH = struct.Struct("<I")
_CODES = {
    "?": "?", "u1": "B", "i1": "b", "u2": "H", "i2": "h", "u4": "I", "i4": "i",
    "u8": "Q", "i8": "q", "f4": "f", "f8": "d",
}  # fmt: skip
_SCALARS = {kind: struct.Struct("<" + _CODES[code]) for kind, code in PRIMITIVES.items()}


@dataclass(frozen=True, slots=True)
class FieldLocation:
    """Location of a numeric field in the bytes of a message.

    Attributes:
        path: path of the field, e.g. "pose.position.x" or "transforms[2].header.stamp.sec".
        offset: offset of the first byte, including the CDR header.
        dtype: type of the numbers, little-endian.
        count: number of numbers.
    """

    path: str
    offset: int
    dtype: np.dtype[Any]
    count: int


def encode(type_name: str, message: object, locations: list[FieldLocation] | None = None) -> bytes:
    """Serialize a message.

    Args:
        type_name: full name of its type.
        message: any object that has the fields of the type as attributes.
        locations: list to which the locations of all numeric fields are appended, or None.

    Raises:
        MessageError: a value does not fit its field of the given name.
    """
    buffer = bytearray(HEADER)
    _encode(buffer, get_definition(type_name), message, "", locations)
    return bytes(buffer)


def decode(type_name: str, data: Any, make: Callable[[str, dict[str, Any]], Any]) -> Any:
    """Deserialize a message of either byte order. Bytes after its end are ignored.

    Args:
        type_name: full name of its type.
        data: bytes-like object.
        make: called with the name of a type and the values of its fields; returns the message.

    Raises:
        MessageError: the bytes end too early or are not a message of this type.
    """
    reader = _CdrReader(memoryview(data).cast("B"), type_name)
    return _decode(reader, get_definition(type_name), make)


def _encode(
    buffer: bytearray,
    form: MessageDefinition,
    message: object,
    path: str,
    locations: list[FieldLocation] | None,
) -> None:
    for field in form.fields:
        where = f"{path}.{field.name}" if path else field.name
        try:
            value = getattr(message, field.name)
        except AttributeError:
            raise MessageError(f"{form.name}: the message has no field '{where}'") from None
        if field.multiplicity is Multiplicity.ONE:
            if field.nested:
                _encode(buffer, get_definition(field.type), value, where, locations)
            elif field.type == "string":
                _encode_string(buffer, value, field, where)
            else:
                _encode_scalar(buffer, value, field, where, locations)
        else:
            _encode_array(buffer, value, field, where, locations)


def _encode_scalar(
    buffer: bytearray, value: Any, field: Field, where: str, locations: list[FieldLocation] | None
) -> None:
    form = _SCALARS[field.type]
    _align(buffer, form.size)
    if locations is not None:
        locations.append(FieldLocation(where, len(buffer), _dtype(field.type), 1))
    try:
        buffer += form.pack(value)
    except struct.error as error:
        raise MessageError(f"{where} = {value!r} is not a valid {field.type}: {error}") from None


def _encode_string(buffer: bytearray, value: Any, field: Field, where: str) -> None:
    if not isinstance(value, str):
        raise MessageError(f"{where} = {value!r} is not a string")
    text = value.encode("utf-8", "surrogatepass")
    if field.max_length and len(text) > field.max_length:
        raise MessageError(f"{where} has {len(text)} bytes; at most {field.max_length} are allowed")
    _align(buffer, 4)
    buffer += _LENGTH.pack(len(text) + 1) + text + b"\0"


def _encode_array(
    buffer: bytearray, value: Any, field: Field, where: str, locations: list[FieldLocation] | None
) -> None:
    try:
        count = len(value)
    except TypeError:
        raise MessageError(f"{where} = {value!r} is not an array") from None
    if field.multiplicity is Multiplicity.ARRAY and count != field.size:
        raise MessageError(f"{where} has {count} elements; there must be {field.size}")
    if field.multiplicity is Multiplicity.BOUNDED and count > field.size:
        raise MessageError(f"{where} has {count} elements; at most {field.size} are allowed")
    if field.multiplicity is not Multiplicity.ARRAY:
        _align(buffer, 4)
        buffer += _LENGTH.pack(count)
    if field.nested:
        form = get_definition(field.type)
        for i, one in enumerate(value):
            _encode(buffer, form, one, f"{where}[{i}]", locations)
    elif field.type == "string":
        for i, one in enumerate(value):
            _encode_string(buffer, one, field, f"{where}[{i}]")
    elif count:
        dtype = _dtype(field.type)
        try:
            numbers = np.asarray(value, dtype=dtype)
        except (TypeError, ValueError, OverflowError) as error:
            raise MessageError(f"{where} is not an array of {field.type}: {error}") from None
        if numbers.ndim != 1:
            raise MessageError(f"{where} has shape {numbers.shape}; it must have one dimension")
        _align(buffer, dtype.itemsize)
        if locations is not None:
            locations.append(FieldLocation(where, len(buffer), dtype, count))
        buffer += numbers.tobytes()


def _align(buffer: bytearray, size: int) -> None:
    missing = -(len(buffer) - len(HEADER)) % size
    if missing:
        buffer += bytes(missing)


def _dtype(kind: str) -> np.dtype[Any]:
    return np.dtype(PRIMITIVES[kind]).newbyteorder("<")


class _CdrReader:
    """Reads serialized values one after another.

    Args:
        data: CDR header and body.
        name: name of the type, for error messages.

    Attributes:
        order: byte order.
    """

    def __init__(self, data: memoryview, name: str) -> None:
        header = bytes(data[:2])
        if len(data) < len(HEADER) or header not in (_LITTLE_ENDIAN, _HEADER_BIG_ENDIAN):
            raise MessageError(
                f"{name}: {bytes(data[:4]).hex(' ') or 'nothing'} is not the header of a plain CDR "
                "(XCDR1) message; expected 00 01 00 00"
            )
        self.order: Literal["<", ">"] = "<" if header == _LITTLE_ENDIAN else ">"
        self.name = name
        self._data = data[len(HEADER) :]
        self._at = 0

    def take(self, size: int, align: int) -> memoryview:
        """Return the next `size` bytes after alignment."""
        start = self._at + -self._at % align
        stop = start + size
        if stop > len(self._data):
            raise MessageError(
                f"{self.name}: {size} bytes expected at offset {start}, but there are "
                f"only {len(self._data)} bytes"
            )
        self._at = stop
        return self._data[start:stop]

    def length(self) -> int:
        """Return the next length, which cannot exceed the rest of the message."""
        value = int(struct.unpack(self.order + "I", self.take(4, 4))[0])
        if value > len(self._data) - self._at:
            raise MessageError(
                f"{self.name}: length {value} at offset {self._at - 4}, but only "
                f"{len(self._data) - self._at} bytes follow"
            )
        return value


def _decode(
    reader: _CdrReader, form: MessageDefinition, make: Callable[[str, dict[str, Any]], Any]
) -> Any:
    return make(form.name, {f.name: _decode_field(reader, f, make) for f in form.fields})


def _decode_field(
    reader: _CdrReader, field: Field, make: Callable[[str, dict[str, Any]], Any]
) -> Any:
    if field.multiplicity is Multiplicity.ONE:
        if field.nested:
            return _decode(reader, get_definition(field.type), make)
        if field.type == "string":
            return _decode_string(reader)
        dtype = np.dtype(PRIMITIVES[field.type]).newbyteorder(reader.order)
        data = reader.take(dtype.itemsize, dtype.itemsize)
        return np.frombuffer(data, dtype)[0].item()
    count = field.size if field.multiplicity is Multiplicity.ARRAY else reader.length()
    if field.multiplicity is Multiplicity.BOUNDED and count > field.size:
        raise MessageError(
            f"{reader.name}: '{field.name}' has {count} elements, at most {field.size} are allowed"
        )
    if field.nested:
        form = get_definition(field.type)
        return [_decode(reader, form, make) for _ in range(count)]
    if field.type == "string":
        return [_decode_string(reader) for _ in range(count)]
    dtype = np.dtype(PRIMITIVES[field.type]).newbyteorder(reader.order)
    if not count:
        return np.empty(0, PRIMITIVES[field.type])
    data = reader.take(count * dtype.itemsize, dtype.itemsize)
    return np.frombuffer(data, dtype).astype(PRIMITIVES[field.type])


def _decode_string(reader: _CdrReader) -> str:
    data = bytes(reader.take(reader.length(), 1))
    # Some writers send an empty string as length 0, without its zero.
    return data[: -1 if data.endswith(b"\0") else None].decode("utf-8", "surrogateescape")

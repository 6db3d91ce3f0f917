"""CDR, the bytes of a message on the wire and in logs: OMG's XCDR version 1, plain.

Four bytes of header (`00 01 00 00`: little-endian), then the fields in order, each number
aligned to its size counted from the end of the header. A string is its length with the
final zero (uint32), its UTF-8 bytes and the zero; a sequence its length, then its elements.

Source: OMG DDS-XTypes 1.3, §7.4; OMG CORBA 3.3, part 2, §9.3.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from wbc.messages.definition import PRIMITIVES, Definition, Field, Shape
from wbc.messages.errors import MessageError
from wbc.messages.library import definition

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
class Place:
    """Where numbers of a message lie in its bytes.

    Attributes:
        path: of the field, e.g. "pose.position.x" or "transforms[2].header.stamp.sec".
        offset: of the first byte, the header counted.
        dtype: of the numbers, little-endian.
        count: how many.
    """

    path: str
    offset: int
    dtype: np.dtype[Any]
    count: int


def encode(type_name: str, message: object, places: list[Place] | None = None) -> bytes:
    """A message's bytes.

    Args:
        type_name: full name of its type.
        message: any object with the type's fields as attributes.
        places: filled with where each number lies, if given.

    Raises:
        MessageError: a value does not fit its field; the text names it.
    """
    buffer = bytearray(HEADER)
    _encode(buffer, definition(type_name), message, "", places)
    return bytes(buffer)


def decode(type_name: str, data: Any, make: Callable[[str, dict[str, Any]], Any]) -> Any:
    """A message from its bytes, of either byte order. Bytes after the end are ignored.

    Args:
        type_name: full name of its type.
        data: bytes-like.
        make: called with a type's name and its fields' values, makes the message.

    Raises:
        MessageError: the bytes end too early, or are no message of this type.
    """
    source = _Source(memoryview(data).cast("B"), type_name)
    return _decode(source, definition(type_name), make)


def _encode(
    buffer: bytearray, form: Definition, message: object, path: str, places: list[Place] | None
) -> None:
    for field in form.fields:
        where = f"{path}.{field.name}" if path else field.name
        try:
            value = getattr(message, field.name)
        except AttributeError:
            raise MessageError(f"{form.name}: the message has no '{where}'") from None
        if field.shape is Shape.ONE:
            if field.nested:
                _encode(buffer, definition(field.type), value, where, places)
            elif field.type == "string":
                _encode_string(buffer, value, field, where)
            else:
                _encode_scalar(buffer, value, field, where, places)
        else:
            _encode_array(buffer, value, field, where, places)


def _encode_scalar(
    buffer: bytearray, value: Any, field: Field, where: str, places: list[Place] | None
) -> None:
    form = _SCALARS[field.type]
    _align(buffer, form.size)
    if places is not None:
        places.append(Place(where, len(buffer), _dtype(field.type), 1))
    try:
        buffer += form.pack(value)
    except struct.error as error:
        raise MessageError(f"{where} = {value!r} is no {field.type}: {error}") from None


def _encode_string(buffer: bytearray, value: Any, field: Field, where: str) -> None:
    if not isinstance(value, str):
        raise MessageError(f"{where} = {value!r} is no string")
    text = value.encode("utf-8", "surrogatepass")
    if field.bound and len(text) > field.bound:
        raise MessageError(f"{where} has {len(text)} bytes; at most {field.bound} are allowed")
    _align(buffer, 4)
    buffer += _LENGTH.pack(len(text) + 1) + text + b"\0"


def _encode_array(
    buffer: bytearray, value: Any, field: Field, where: str, places: list[Place] | None
) -> None:
    try:
        count = len(value)
    except TypeError:
        raise MessageError(f"{where} = {value!r} is no array") from None
    if field.shape is Shape.ARRAY and count != field.size:
        raise MessageError(f"{where} has {count} elements; there must be {field.size}")
    if field.shape is Shape.BOUNDED and count > field.size:
        raise MessageError(f"{where} has {count} elements; at most {field.size} are allowed")
    if field.shape is not Shape.ARRAY:
        _align(buffer, 4)
        buffer += _LENGTH.pack(count)
    if field.nested:
        form = definition(field.type)
        for i, one in enumerate(value):
            _encode(buffer, form, one, f"{where}[{i}]", places)
    elif field.type == "string":
        for i, one in enumerate(value):
            _encode_string(buffer, one, field, f"{where}[{i}]")
    elif count:
        dtype = _dtype(field.type)
        try:
            numbers = np.asarray(value, dtype=dtype)
        except (TypeError, ValueError, OverflowError) as error:
            raise MessageError(f"{where} is no array of {field.type}: {error}") from None
        if numbers.ndim != 1:
            raise MessageError(f"{where} has shape {numbers.shape}; it must have one dimension")
        _align(buffer, dtype.itemsize)
        if places is not None:
            places.append(Place(where, len(buffer), dtype, count))
        buffer += numbers.tobytes()


def _align(buffer: bytearray, size: int) -> None:
    missing = -(len(buffer) - len(HEADER)) % size
    if missing:
        buffer += bytes(missing)


def _dtype(kind: str) -> np.dtype[Any]:
    return np.dtype(PRIMITIVES[kind]).newbyteorder("<")


class _Source:
    """Bytes that are read one after another.

    Args:
        data: header and body.
        name: of the type, for errors.
    """

    def __init__(self, data: memoryview, name: str) -> None:
        header = bytes(data[:2])
        if len(data) < len(HEADER) or header not in (_LITTLE_ENDIAN, _HEADER_BIG_ENDIAN):
            raise MessageError(
                f"{name}: {bytes(data[:4]).hex(' ') or 'nothing'} is no header of a plain CDR "
                "(XCDR1) message; that would be 00 01 00 00"
            )
        self.order: Literal["<", ">"] = "<" if header == _LITTLE_ENDIAN else ">"
        self.name = name
        self._data = data[len(HEADER) :]
        self._at = 0

    def take(self, size: int, align: int) -> memoryview:
        """The next bytes."""
        start = self._at + -self._at % align
        stop = start + size
        if stop > len(self._data):
            raise MessageError(
                f"{self.name}: {size} bytes are due at {start}, and it has only {len(self._data)}"
            )
        self._at = stop
        return self._data[start:stop]

    def length(self) -> int:
        """A length, which cannot be larger than the rest of the message."""
        value = int(struct.unpack(self.order + "I", self.take(4, 4))[0])
        if value > len(self._data) - self._at:
            raise MessageError(
                f"{self.name}: a length of {value} at {self._at - 4}, and only "
                f"{len(self._data) - self._at} bytes follow"
            )
        return value


def _decode(source: _Source, form: Definition, make: Callable[[str, dict[str, Any]], Any]) -> Any:
    return make(form.name, {f.name: _decode_field(source, f, make) for f in form.fields})


def _decode_field(source: _Source, field: Field, make: Callable[[str, dict[str, Any]], Any]) -> Any:
    if field.shape is Shape.ONE:
        if field.nested:
            return _decode(source, definition(field.type), make)
        if field.type == "string":
            return _decode_string(source)
        dtype = np.dtype(PRIMITIVES[field.type]).newbyteorder(source.order)
        data = source.take(dtype.itemsize, dtype.itemsize)
        return np.frombuffer(data, dtype)[0].item()
    count = field.size if field.shape is Shape.ARRAY else source.length()
    if field.shape is Shape.BOUNDED and count > field.size:
        raise MessageError(
            f"{source.name}: '{field.name}' has {count} elements, and at most {field.size} may be"
        )
    if field.nested:
        form = definition(field.type)
        return [_decode(source, form, make) for _ in range(count)]
    if field.type == "string":
        return [_decode_string(source) for _ in range(count)]
    dtype = np.dtype(PRIMITIVES[field.type]).newbyteorder(source.order)
    if not count:
        return np.empty(0, PRIMITIVES[field.type])
    data = source.take(count * dtype.itemsize, dtype.itemsize)
    return np.frombuffer(data, dtype).astype(PRIMITIVES[field.type])


def _decode_string(source: _Source) -> str:
    data = bytes(source.take(source.length(), 1))
    # Some writers send an empty string as length 0, without its zero.
    return data[: -1 if data.endswith(b"\0") else None].decode("utf-8", "surrogateescape")

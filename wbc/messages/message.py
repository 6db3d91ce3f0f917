"""Message classes, whose fields are checked when they are set."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache, partial
from operator import index
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from wbc.errors import WbcError, did_you_mean
from wbc.messages.typestore import number_dtype, typestore

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc

MessageT = TypeVar("MessageT", bound="Message")
_UNLIMITED = 2**32 - 1
_PYTHON_NUMBERS: dict[str, Callable[[Any], Any]] = {"b": bool, "i": index, "u": index, "f": float}
#: Initial values that are not zero; `rosbags` does not keep them.
_DEFAULTS = {("geometry_msgs/msg/Quaternion", "w"): 1.0}


class MessageError(WbcError, ValueError):
    """A type is unknown, bytes are no message of their type, or a value does not fit."""


class Message:
    """Base class of all messages; `message_type(name)` returns the class of a type.

    Numbers are Python numbers, arrays of numbers are numpy arrays, other arrays are lists. A value
    that does not fit its field is refused with a `MessageError`.

    Attributes:
        type_name: full name of the type, e.g. "geometry_msgs/msg/Point"; an attribute of the class.
    """

    type_name: ClassVar[str]
    _convert: ClassVar[dict[str, Callable[[Any], Any]]]

    if TYPE_CHECKING:

        def __init__(self, **values: Any) -> None: ...
        def __getattr__(self, name: str) -> Any: ...

    def __setattr__(self, name: str, value: Any) -> None:
        try:
            super().__setattr__(name, self._convert[name](value))
        except KeyError:
            known = did_you_mean(name, self._convert)
            raise MessageError(f"{type(self).type_name} has no field '{name}'{known}") from None
        except (TypeError, ValueError, OverflowError) as error:
            text = f"{type(self).type_name}: {name} = {value!r:.100}: {error}"
            raise MessageError(text) from None

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Message) or type(other).type_name != type(self).type_name:
            return NotImplemented
        return self.encode() == other.encode()

    __hash__ = None  # type: ignore[assignment]

    def encode(self) -> bytes:
        """Serialize the message to CDR, header included.

        Raises:
            MessageError: an element of an array does not fit.
        """
        try:
            return bytes(typestore().serialize_cdr(self, type(self).type_name, little_endian=True))
        except (AttributeError, TypeError, ValueError) as error:
            raise MessageError(f"{type(self).type_name} cannot be serialized: {error}") from error

    @classmethod
    def decode(cls: type[MessageT], data: Any) -> MessageT:
        """Deserialize a message of either byte order from CDR.

        Raises:
            MessageError: the bytes are not a message of this type.
        """
        from rosbags.serde import SerdeError

        try:
            # Only the arrays of a bytearray are writable.
            message: Any = typestore().deserialize_cdr(bytearray(data), cls.type_name)  # type: ignore[arg-type]
        except SerdeError as error:
            raise MessageError(f"{cls.type_name}: {error}") from error
        return message  # type: ignore[no-any-return]

    @classmethod
    def element_type(cls, field: str) -> type[Message] | None:
        """Return the class of the elements of a field that is a list of messages; else None."""
        from rosbags.interfaces import Nodetype

        for name, desc in typestore().fielddefs[cls.type_name][1]:
            match desc:
                case (Nodetype.ARRAY | Nodetype.SEQUENCE, ((Nodetype.NAME, element), _)):
                    if name == field:
                        return message_type(element)
        return None

    @classmethod
    def schema(cls) -> str:
        """Return the definition with those of all nested types, in the format `ros2msg` of mcap."""
        return typestore().generate_msgdef(cls.type_name, ros_version=2)[0]

    @classmethod
    def type_hash(cls) -> str:
        """Return the type hash, `RIHS01_` and 64 hexadecimal digits (REP 2016)."""
        return typestore().hash_rihs01(cls.type_name)

    @classmethod
    def dds_name(cls) -> str:
        """Return the name of the type in DDS, `pkg::msg::dds_::Name_`."""
        package, kind, name = cls.type_name.split("/")
        return f"{package}::{kind}::dds_::{name}_"


@cache
def message_type(name: str) -> type[Message]:
    """Return the class of a message type.

    Example:
        >>> Twist = message_type("geometry_msgs/msg/Twist")
        >>> Twist.decode(Twist().encode()).linear.x
        0.0

    Args:
        name: `pkg/msg/Name`, or a part of a service or an action (see `typestore`).

    Raises:
        MessageError: there is no such type; the message suggests similar names.
        MissingExtra: `rosbags` is not installed.
    """
    store = typestore()
    if name not in store.fielddefs:
        near = did_you_mean(name, store.fielddefs)
        raise MessageError(f"there is no message type '{name}'{near}")
    constants, definitions = store.fielddefs[name]
    kinds = {field: _field(desc) for field, desc in definitions}
    fields: list[Any] = [
        (field, Any, _DEFAULTS.get((name, field), dataclasses.field(default_factory=zero)))
        for field, (_, zero) in kinds.items()
    ]
    namespace = {
        **{constant: value for constant, _, value in constants},
        "_convert": {field: convert for field, (convert, _) in kinds.items()},
        "__module__": __name__,
    }
    short = name.rpartition("/")[2]
    made: Any = dataclasses.make_dataclass(
        short, fields, bases=(Message,), namespace=namespace, eq=False
    )
    made.type_name = name  # set afterwards: some messages have a field of this name
    store.types[name] = made  # what `rosbags` makes on deserialization
    return made  # type: ignore[no-any-return]


def _field(desc: FieldDesc) -> tuple[Callable[[Any], Any], Callable[[], Any]]:
    """Return a function that checks and converts values of a field, and one that returns zero."""
    from rosbags.interfaces import Nodetype

    match desc:
        case Nodetype.BASE, ("string", limit):
            return partial(_text, limit or _UNLIMITED), str
        case Nodetype.BASE, (primitive, _):
            dtype = number_dtype(primitive)
            return partial(_number, dtype), dtype.type().item
        case Nodetype.NAME, name:
            made = message_type(name)
            return partial(_message, made), made
        case shape, (element, size):
            least, most = (size if shape == Nodetype.ARRAY else 0), size or _UNLIMITED
            match element:
                case Nodetype.BASE, (primitive, _) if primitive != "string":
                    dtype = number_dtype(primitive)
                    return partial(_array, dtype, least, most), partial(np.zeros, least, dtype)
            convert, zero = _field(element)
            return partial(_list, convert, least, most), lambda: [zero() for _ in range(least)]
    raise AssertionError(f"a field of an unknown kind: {desc}")


def _text(most: int, value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError("it must be a string")
    _check_length(len(value.encode()), 0, most)
    return value


def _number(dtype: np.dtype[Any], value: Any) -> Any:
    return dtype.type(_PYTHON_NUMBERS[dtype.kind](value)).item()


def _message(kind: type[Message], value: Any) -> Message:
    if not isinstance(value, kind):
        raise TypeError(f"it must be a {kind.type_name}")
    return value


def _array(dtype: np.dtype[Any], least: int, most: int, value: Any) -> np.ndarray:
    given = np.asarray(value)
    with np.errstate(invalid="ignore"):
        array = np.asarray(given, dtype, order="C")
    if array.ndim != 1:
        raise ValueError(f"it has shape {array.shape}; it must have one dimension")
    if dtype.kind in "iu" and not np.array_equal(array, given):  # numpy wraps and truncates
        raise ValueError(f"its numbers must be of type {dtype}")
    _check_length(len(array), least, most)
    return array


def _list(convert: Callable[[Any], Any], least: int, most: int, value: Any) -> list[Any]:
    found = [convert(element) for element in value]
    _check_length(len(found), least, most)
    return found


def _check_length(length: int, least: int, most: int) -> None:
    if not least <= length <= most:
        raise ValueError(f"its length is {length}; it must be between {least} and {most}")

"""Message classes: dataclasses that are created from message definitions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from wbc.messages.cdr import decode, encode
from wbc.messages.definition import PRIMITIVES, Field, Multiplicity, full_name
from wbc.messages.registry import get_definition, schema_text
from wbc.messages.type_hash import type_hash

MessageT = TypeVar("MessageT", bound="Message")


class Message:
    """Base class of all messages; `message_type(name)` returns the class of a type.

    Numbers are Python numbers, arrays of numbers are numpy arrays, other arrays are lists.

    Attributes:
        type_name: full name of the type, e.g. "geometry_msgs/msg/Point".
    """

    type_name: ClassVar[str]

    if TYPE_CHECKING:

        def __init__(self, **values: Any) -> None: ...
        def __getattr__(self, name: str) -> Any: ...
        def __setattr__(self, name: str, value: Any) -> None: ...

    def encode(self) -> bytes:
        """Serialize the message to CDR, header included.

        Raises:
            MessageError: a value does not fit its field.
        """
        return encode(self.type_name, self)

    @classmethod
    def decode(cls: type[MessageT], data: Any) -> MessageT:
        """Deserialize a message from CDR.

        Raises:
            MessageError: the bytes are not a message of this type.
        """
        message: MessageT = decode(cls.type_name, data, _make)
        return message

    @classmethod
    def schema(cls) -> str:
        """Return the definition with those of all nested types, in the format `ros2msg` of mcap."""
        return schema_text(cls.type_name)

    @classmethod
    def type_hash(cls) -> str:
        """Return the type hash, `RIHS01_…` (REP 2016)."""
        return type_hash(cls.type_name)

    @classmethod
    def dds_name(cls) -> str:
        """Return the name of the type in DDS, `pkg::msg::dds_::Name_`."""
        package, kind, name = cls.type_name.split("/")
        return f"{package}::{kind}::dds_::{name}_"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Message) or other.type_name != self.type_name:
            return NotImplemented
        return self.encode() == other.encode()

    __hash__ = None  # type: ignore[assignment]


@cache
def message_type(name: str) -> type[Message]:
    """Return the class of a message type.

    Example:
        >>> Twist = message_type("geometry_msgs/msg/Twist")
        >>> Twist.decode(Twist().encode()).linear.x
        0.0

    Args:
        name: `pkg/msg/Name` or `pkg/Name`, or a part of a service or an action (see
            `get_definition`).

    Raises:
        MessageError: there is no such type; the message suggests similar names.
    """
    form = get_definition(name)
    if form.name != name:
        return message_type(form.name)
    fields = [(f.name, Any, dataclasses.field(default_factory=_default(f))) for f in form.fields]
    constants = {key: value for key, value in form.constants if key.isidentifier()}
    made = dataclasses.make_dataclass(
        name.rpartition("/")[2],
        fields,
        bases=(Message,),
        namespace={**constants, "type_name": full_name(name), "__doc__": form.text},
        eq=False,
        kw_only=True,
    )
    made.__module__ = __name__
    return made


def _make(name: str, values: dict[str, Any]) -> Message:
    return message_type(name)(**values)


def _default(field: Field) -> Callable[[], Any]:
    if field.multiplicity is not Multiplicity.ONE:
        count = field.size if field.multiplicity is Multiplicity.ARRAY else 0
        if field.nested:
            return lambda: [message_type(field.type)() for _ in range(count)]
        if field.type == "string":
            return lambda: [""] * count
        dtype = PRIMITIVES[field.type]
        if isinstance(field.default, (list, tuple)):
            numbers = np.array(field.default, dtype)
            return numbers.copy
        return lambda: np.zeros(count, dtype)
    if field.nested:
        return message_type(field.type)
    zero: Any = "" if field.type == "string" else np.zeros((), PRIMITIVES[field.type]).item()
    value = zero if field.default is None else type(zero)(field.default)
    return lambda: value

"""Message definitions, parsed from the text of `.msg`, `.srv` and `.action` files.

The grammar is that of the ROS 2 interface definition (rosidl), without `wstring`.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from enum import Enum

from wbc.messages.errors import MessageError

PRIMITIVES = {
    "bool": "?",
    "byte": "u1",
    "char": "u1",
    "uint8": "u1",
    "int8": "i1",
    "uint16": "u2",
    "int16": "i2",
    "uint32": "u4",
    "int32": "i4",
    "uint64": "u8",
    "int64": "i8",
    "float32": "f4",
    "float64": "f8",
}
#: DDS has no empty structure: ROS gives one this member.
EMPTY_MEMBER = "structure_needs_at_least_one_member"

_FIELD = re.compile(
    r"(?P<type>[A-Za-z][\w/]*?)(?:<=(?P<string>\d+))?"
    r"(?P<array>\[(?P<bounded><=)?(?P<size>\d*)\])?"
    r"\s+(?P<name>[a-z]\w*)(?:\s+(?P<default>.+))?"
)
_CONSTANT = re.compile(r"(?P<type>[a-z]\w*)(?:<=\d+)?\s+(?P<name>[A-Z]\w*)\s*=\s*(?P<value>.+)")


class Multiplicity(Enum):
    """How many values of its type a field holds."""

    ONE = "one"
    ARRAY = "array"  #: exactly `Field.size`
    BOUNDED = "bounded"  #: at most `Field.size`
    SEQUENCE = "sequence"  #: any number


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message.

    Attributes:
        name: name of the field.
        type: a primitive, "string", or the full name of a message.
        multiplicity: a single value, or the kind of array.
        size: length of an array, or the maximum length of a bounded sequence.
        max_length: maximum length of a string, bytes; 0 for no limit.
        default: initial value; None for zero or empty.
    """

    name: str
    type: str
    multiplicity: Multiplicity = Multiplicity.ONE
    size: int = 0
    max_length: int = 0
    default: object = None

    @property
    def nested(self) -> bool:
        """Whether the type is a message."""
        return "/" in self.type


@dataclass(frozen=True, slots=True)
class MessageDefinition:
    """Definition of a message type.

    Attributes:
        name: full name, e.g. "geometry_msgs/msg/Point".
        fields: the fields in order, at least one.
        constants: names and values of the constants.
        text: the text of the definition.
    """

    name: str
    fields: tuple[Field, ...]
    constants: tuple[tuple[str, object], ...] = ()
    text: str = ""


def full_name(name: str) -> str:
    """Return `pkg/msg/Name` for `pkg/Name`; a full name unchanged.

    Raises:
        MessageError: it is not the name of a type.
    """
    parts = name.split("/")
    if len(parts) == 2:
        parts.insert(1, "msg")
    if len(parts) != 3 or not all(re.fullmatch(r"[A-Za-z]\w*", part) for part in parts):
        raise MessageError(f"'{name}' is not the name of a message type; use pkg/msg/Name")
    return "/".join(parts)


def parse(name: str, text: str) -> MessageDefinition:
    """Parse the definition of a message type.

    Args:
        name: full name; types without a package belong to the same package.
        text: text of a `.msg` file, or of one part of a `.srv` or `.action` file.

    Raises:
        MessageError: a line does not follow the grammar.
    """
    package = name.split("/")[0]
    fields, constants = [], []
    for number, line in enumerate(text.splitlines(), 1):
        line = _without_comment(line)
        if not line:
            continue
        if constant := _CONSTANT.fullmatch(line):
            constants.append((constant["name"], _value(constant["value"])))
        elif field := _FIELD.fullmatch(line):
            fields.append(_field(field, package))
        else:
            raise MessageError(f"{name}, line {number}: '{line}' is neither a field nor a constant")
    if not fields:
        fields.append(Field(EMPTY_MEMBER, "uint8"))
    return MessageDefinition(name, tuple(fields), tuple(constants), text.strip())


def _field(match: re.Match[str], package: str) -> Field:
    kind = match["type"]
    if kind == "wstring":
        raise MessageError(f"field '{match['name']}': wstring is not supported; use string")
    if kind not in PRIMITIVES and kind != "string":
        near = "builtin_interfaces/" if kind in ("time", "duration") else f"{package}/"
        kind = full_name(kind if "/" in kind else near + kind)
    if match["array"] is None:
        multiplicity = Multiplicity.ONE
    elif not match["size"]:
        multiplicity = Multiplicity.SEQUENCE
    else:
        multiplicity = Multiplicity.BOUNDED if match["bounded"] else Multiplicity.ARRAY
    default = None if match["default"] is None else _value(match["default"])
    return Field(
        match["name"],
        kind,
        multiplicity,
        int(match["size"] or 0),
        int(match["string"] or 0),
        default,
    )


def _without_comment(line: str) -> str:
    quote = ""
    for i, letter in enumerate(line):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter == "#":
            line = line[:i]
            break
    return line.strip()


def _value(text: str) -> object:
    text = text.strip()
    if text in ("true", "false"):
        return text == "true"
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text

"""Message definitions: the text of `.msg`, `.srv` and `.action` files, parsed.

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


class Shape(Enum):
    """How many there are of a field's type."""

    ONE = "one"
    ARRAY = "array"  #: as many as `Field.size`
    BOUNDED = "bounded"  #: at most `Field.size`
    SEQUENCE = "sequence"  #: any number


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message.

    Attributes:
        name: of the field.
        type: a primitive, "string", or the full name of a message.
        shape: one, or an array of some kind.
        size: of an array, or its bound.
        bound: largest length of a string, 0 for none.
        default: value of a new message's field; None: zero, empty.
    """

    name: str
    type: str
    shape: Shape = Shape.ONE
    size: int = 0
    bound: int = 0
    default: object = None

    @property
    def nested(self) -> bool:
        """Whether the type is a message."""
        return "/" in self.type


@dataclass(frozen=True, slots=True)
class Definition:
    """The form of a message.

    Attributes:
        name: full, e.g. "geometry_msgs/msg/Point".
        fields: in order, at least one.
        constants: by name.
        text: as in the file.
    """

    name: str
    fields: tuple[Field, ...]
    constants: tuple[tuple[str, object], ...] = ()
    text: str = ""


def full_name(name: str) -> str:
    """`pkg/Name` as `pkg/msg/Name`.

    Raises:
        MessageError: it is no name of a type.
    """
    parts = name.split("/")
    if len(parts) == 2:
        parts.insert(1, "msg")
    if len(parts) != 3 or not all(re.fullmatch(r"[A-Za-z]\w*", part) for part in parts):
        raise MessageError(f"'{name}' is no name of a message type; they look like pkg/msg/Name")
    return "/".join(parts)


def parse(name: str, text: str) -> Definition:
    """The definition of a message.

    Args:
        name: full name; types without a package are of the same one.
        text: of a `.msg` file, or of one part of a `.srv` or `.action` file.

    Raises:
        MessageError: a line is none of the grammar's.
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
            raise MessageError(f"{name}, line {number}: '{line}' is neither field nor constant")
    if not fields:
        fields.append(Field(EMPTY_MEMBER, "uint8"))
    return Definition(name, tuple(fields), tuple(constants), text.strip())


def _field(match: re.Match[str], package: str) -> Field:
    kind = match["type"]
    if kind == "wstring":
        raise MessageError(f"field '{match['name']}': wstring is not supported; use string")
    if kind not in PRIMITIVES and kind != "string":
        near = "builtin_interfaces/" if kind in ("time", "duration") else f"{package}/"
        kind = full_name(kind if "/" in kind else near + kind)
    if match["array"] is None:
        shape = Shape.ONE
    elif not match["size"]:
        shape = Shape.SEQUENCE
    else:
        shape = Shape.BOUNDED if match["bounded"] else Shape.ARRAY
    default = None if match["default"] is None else _value(match["default"])
    return Field(
        match["name"], kind, shape, int(match["size"] or 0), int(match["string"] or 0), default
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

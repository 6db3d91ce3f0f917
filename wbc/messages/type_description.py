"""Descriptions of message types as messages, from which others can decode them.

Source: REP 2016, "Type Descriptions".
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wbc.messages.message import Message, MessageError, message_type
from wbc.messages.typestore import typestore

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc

_PACKAGE = "type_description_interfaces/msg"
#: What the number of an element's type grows by for an array, a bounded and an unbounded sequence.
_ARRAY, _BOUNDED_SEQUENCE, _SEQUENCE = 48, 96, 144


def type_description(type_name: str) -> Message:
    """Return the `TypeDescription` of a message type, with the types of its fields.

    Args:
        type_name: `pkg/msg/Name`.

    Raises:
        MessageError: There is no such type.
    """
    found: dict[str, Any] = {}
    _describe(type_name, found)
    own = found.pop(type_name)
    return message_type(f"{_PACKAGE}/TypeDescription")(
        type_description=own,
        referenced_type_descriptions=[found[name] for name in sorted(found)],
    )


def _describe(type_name: str, found: dict[str, Any]) -> None:
    """Add the description of a type, and of those of its fields, by their names."""
    if type_name in found:
        return
    definitions = typestore().fielddefs
    if type_name not in definitions:
        raise MessageError(f"there is no message type '{type_name}'")
    found[type_name] = None  # keeps its place
    _, fields = definitions[type_name]
    kind = message_type(f"{_PACKAGE}/Field")
    described = [kind(name=name, type=_field_type(field, found)) for name, field in fields]
    found[type_name] = message_type(f"{_PACKAGE}/IndividualTypeDescription")(
        type_name=type_name, fields=described
    )


def _field_type(field: FieldDesc, found: dict[str, Any]) -> Message:
    from rosbags.interfaces import Nodetype
    from rosbags.typesys.store import TIDMAP

    node: Any
    detail: Any  # of each kind of node another
    node, detail = field
    increment = capacity = string_capacity = 0
    nested = ""
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        (node, detail), capacity = detail
        if field[0] == Nodetype.ARRAY:
            increment = _ARRAY
        else:
            increment = _BOUNDED_SEQUENCE if capacity else _SEQUENCE
    if node == Nodetype.NAME:
        number, nested = 1, str(detail)
        _describe(nested, found)
    else:
        primitive, string_capacity = detail
        number = TIDMAP["bounded_string" if string_capacity else primitive]
    return message_type(f"{_PACKAGE}/FieldType")(
        type_id=increment + number,
        capacity=capacity,
        string_capacity=string_capacity,
        nested_type_name=nested,
    )

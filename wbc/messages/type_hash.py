"""Type hashes, by which ROS 2 systems check that they use the same definition of a type.

The hash is the SHA-256 of the descriptions of the type and its nested types, as JSON in a
canonical format. Source: REP 2016, ROS 2 Interface Type Descriptions, and rosidl's
`HashedTypeDescription` (RIHS01).
"""

from __future__ import annotations

import hashlib
import json
from typing import Any

from wbc.messages.definition import Field, MessageDefinition, Multiplicity, parse
from wbc.messages.registry import dependencies, get_definition

_IDS = {
    "int8": 2,
    "uint8": 3,
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "char": 3,
    "bool": 15,
    "byte": 16,
    "string": 17,
}
_NESTED, _BOUNDED_STRING = 1, 21
_SHAPES = {
    Multiplicity.ONE: 0,
    Multiplicity.ARRAY: 48,
    Multiplicity.BOUNDED: 96,
    Multiplicity.SEQUENCE: 144,
}


def type_hash(name: str) -> str:
    """Return the hash of a message type, `RIHS01_` and 64 hexadecimal digits.

    Raises:
        MessageError: there is no such type.
    """
    return _hash(get_definition(name), dependencies(name))


def service_hash(name: str) -> str:
    """Return the hash of a service, `pkg/srv/Name`.

    It covers the request, the response and the service event that contains both.

    Raises:
        MessageError: there is no such service.
    """
    event = parse(
        f"{name}_Event",
        f"service_msgs/ServiceEventInfo info\n{name}_Request[<=1] request\n"
        f"{name}_Response[<=1] response\n",
    )
    whole = parse(
        name,
        f"{name}_Request request_message\n{name}_Response response_message\n"
        f"{name}_Event event_message\n",
    )
    parts = {event.name: event}
    for part in (f"{name}_Request", f"{name}_Response", "service_msgs/msg/ServiceEventInfo"):
        for one in (get_definition(part), *dependencies(part)):
            parts[one.name] = one
    return _hash(whole, tuple(parts.values()))


def _hash(form: MessageDefinition, parts: tuple[MessageDefinition, ...]) -> str:
    description = {
        "type_description": _description(form),
        "referenced_type_descriptions": [
            _description(one) for one in sorted(parts, key=lambda one: one.name)
        ],
    }
    text = json.dumps(description, separators=(", ", ": "), ensure_ascii=True)
    return "RIHS01_" + hashlib.sha256(text.encode()).hexdigest()


def _description(form: MessageDefinition) -> dict[str, Any]:
    return {"type_name": form.name, "fields": [_field(field) for field in form.fields]}


def _field(field: Field) -> dict[str, Any]:
    if field.nested:
        kind = _NESTED
    elif field.max_length:
        kind = _BOUNDED_STRING
    else:
        kind = _IDS[field.type]
    return {
        "name": field.name,
        "type": {
            "type_id": kind + _SHAPES[field.multiplicity],
            "capacity": field.size,
            "string_capacity": field.max_length,
            "nested_type_name": field.type if field.nested else "",
        },
    }

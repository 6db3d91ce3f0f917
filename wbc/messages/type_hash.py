"""Type hashes, by which ROS 2 systems tell whether they mean the same type.

The SHA-256 of the type's description, and those of the types in it, as JSON of a fixed
form. Source: REP 2016, ROS 2 Interface Type Descriptions, and rosidl's
`HashedTypeDescription` (RIHS01).
"""

from __future__ import annotations

import hashlib
import json
from typing import Any

from wbc.messages.definition import Definition, Field, Shape, parse
from wbc.messages.library import definition, dependencies

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
_SHAPES = {Shape.ONE: 0, Shape.ARRAY: 48, Shape.BOUNDED: 96, Shape.SEQUENCE: 144}


def type_hash(name: str) -> str:
    """The hash of a message type, `RIHS01_` and 64 hexadecimal digits.

    Raises:
        MessageError: there is no such type.
    """
    return _hash(definition(name), dependencies(name))


def service_hash(name: str) -> str:
    """The hash of a service, `pkg/srv/Name`.

    Its description has the request, the response and an event made of both.

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
        for one in (definition(part), *dependencies(part)):
            parts[one.name] = one
    return _hash(whole, tuple(parts.values()))


def _hash(form: Definition, parts: tuple[Definition, ...]) -> str:
    description = {
        "type_description": _description(form),
        "referenced_type_descriptions": [
            _description(one) for one in sorted(parts, key=lambda one: one.name)
        ],
    }
    text = json.dumps(description, separators=(", ", ": "), ensure_ascii=True)
    return "RIHS01_" + hashlib.sha256(text.encode()).hexdigest()


def _description(form: Definition) -> dict[str, Any]:
    return {"type_name": form.name, "fields": [_field(field) for field in form.fields]}


def _field(field: Field) -> dict[str, Any]:
    if field.nested:
        kind = _NESTED
    elif field.bound:
        kind = _BOUNDED_STRING
    else:
        kind = _IDS[field.type]
    return {
        "name": field.name,
        "type": {
            "type_id": kind + _SHAPES[field.shape],
            "capacity": field.size,
            "string_capacity": field.bound,
            "nested_type_name": field.type if field.nested else "",
        },
    }

"""Parameters of a node, with the services by which others list, read and change them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING, Any

from wbc.messages import Message, message_type
from wbc.ros.errors import RosError
from wbc.ros.qos import PARAMETER_EVENTS, PARAMETERS

if TYPE_CHECKING:
    from wbc.ros.node import Node

_VALUE = message_type("rcl_interfaces/msg/ParameterValue")
_PARAMETER = message_type("rcl_interfaces/msg/Parameter")
_DESCRIPTOR = message_type("rcl_interfaces/msg/ParameterDescriptor")
_RESULT = message_type("rcl_interfaces/msg/SetParametersResult")
_EVENT = message_type("rcl_interfaces/msg/ParameterEvent")
_FLOAT_RANGE = message_type("rcl_interfaces/msg/FloatingPointRange")
_INTEGER_RANGE = message_type("rcl_interfaces/msg/IntegerRange")


class Kind(IntEnum):
    """The kinds of values, as in `rcl_interfaces/msg/ParameterType`."""

    NOT_SET = 0
    BOOL = 1
    INTEGER = 2
    DOUBLE = 3
    STRING = 4
    BYTE_ARRAY = 5
    BOOL_ARRAY = 6
    INTEGER_ARRAY = 7
    DOUBLE_ARRAY = 8
    STRING_ARRAY = 9


_FIELDS: dict[Kind, tuple[str, type]] = {
    Kind.BOOL: ("bool_value", bool),
    Kind.INTEGER: ("integer_value", int),
    Kind.DOUBLE: ("double_value", float),
    Kind.STRING: ("string_value", str),
    Kind.DOUBLE_ARRAY: ("double_array_value", tuple),
}


@dataclass
class Parameter:
    """A parameter.

    Attributes:
        name: of the parameter.
        value: a truth value, integer, number, text, or tuple of numbers; its type stays.
        description: one line.
        lowest: smallest value (of each number), if there is one.
        highest: largest value, likewise.
        read_only: it cannot be changed by others.
        check: raises a `ValueError` for a value that cannot be.
        changed: called with a new value.
    """

    name: str
    value: Any
    description: str = ""
    lowest: float | None = None
    highest: float | None = None
    read_only: bool = False
    check: Callable[[Any], None] = field(default=lambda _: None)
    changed: Callable[[Any], None] = field(default=lambda _: None)

    @property
    def kind(self) -> Kind:
        """Of its value."""
        return next(kind for kind, (_, t) in _FIELDS.items() if type(self.value) is t)

    def checked(self, message: Message) -> Any:
        """The value in a `ParameterValue`, if this parameter may have it.

        Raises:
            ValueError: it may not; the text says why.
        """
        if self.read_only:
            raise ValueError(f"{self.name} is read-only")
        value = _value(message)
        if type(self.value) is float and type(value) is int:
            value = float(value)
        elif type(self.value) is tuple and message.type == Kind.INTEGER_ARRAY:
            value = tuple(float(x) for x in message.integer_array_value)
        if type(value) is not type(self.value):
            raise ValueError(f"{self.name} is {_words(self.kind)}, not {_words(message.type)}")
        if type(value) is tuple and len(value) != len(self.value):
            raise ValueError(f"{self.name} has {len(self.value)} numbers, not {len(value)}")
        for number in value if type(value) is tuple else (value,):
            if type(number) in (int, float):
                self._check_range(number)
        self.check(value)
        return value

    def _check_range(self, number: float) -> None:
        low = -math.inf if self.lowest is None else self.lowest
        high = math.inf if self.highest is None else self.highest
        if not (math.isfinite(number) and low <= number <= high):
            raise ValueError(f"{self.name} = {number:g} is out of its range, {low:g} to {high:g}")

    def message(self) -> Message:
        """As a `ParameterValue`."""
        return _VALUE(type=self.kind, **{_FIELDS[self.kind][0]: self.value})

    def descriptor(self) -> Message:
        """As a `ParameterDescriptor`."""
        described = _DESCRIPTOR(
            name=self.name,
            type=self.kind,
            description=self.description,
            read_only=self.read_only,
        )
        if self.lowest is not None and self.highest is not None:
            if self.kind == Kind.INTEGER:
                span = _INTEGER_RANGE(from_value=int(self.lowest), to_value=int(self.highest))
                described.integer_range = [span]
            else:
                span = _FLOAT_RANGE(from_value=self.lowest, to_value=self.highest)
                described.floating_point_range = [span]
        return described


class Parameters:
    """A node's parameters, served to others.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._all: dict[str, Parameter] = {}
        self._events = node.publisher(_EVENT.type_name, "/parameter_events", PARAMETER_EVENTS)
        for kind, answer in (
            ("DescribeParameters", self._describe),
            ("GetParameterTypes", self._types),
            ("GetParameters", self._get),
            ("ListParameters", self._list),
            ("SetParameters", self._set),
            ("SetParametersAtomically", self._set_atomically),
        ):
            name = "".join("_" + c.lower() if c.isupper() else c for c in kind)[1:]
            node.service(f"rcl_interfaces/srv/{kind}", f"~/{name}", answer, PARAMETERS)

    def declare(
        self,
        name: str,
        value: Any,
        description: str = "",
        *,
        lowest: float | None = None,
        highest: float | None = None,
        read_only: bool = False,
        check: Callable[[Any], None] = lambda _: None,
        changed: Callable[[Any], None] = lambda _: None,
    ) -> Parameter:
        """Add a parameter; see `Parameter` for the arguments.

        Raises:
            RosError: it exists already, is of no type that a parameter can have, or its value is
                out of its range.
        """
        if name in self._all:
            raise RosError(f"parameter '{name}' is declared twice")
        if type(value) not in {kind for _, kind in _FIELDS.values()}:
            raise RosError(f"parameter '{name}' = {value!r} is of no type that one can have")
        made = Parameter(name, value, description, lowest, highest, False, check, changed)
        try:
            made.checked(made.message())
        except ValueError as error:
            raise RosError(f"parameter {error}") from error
        made.read_only = read_only
        self._all[name] = made
        return made

    def __getitem__(self, name: str) -> Any:
        return self._all[name].value

    def _describe(self, request: Any) -> Message:
        return message_type("rcl_interfaces/srv/DescribeParameters_Response")(
            descriptors=[
                self._all[name].descriptor() if name in self._all else _DESCRIPTOR(name=name)
                for name in request.names
            ]
        )

    def _types(self, request: Any) -> Message:
        unset = Kind.NOT_SET
        return message_type("rcl_interfaces/srv/GetParameterTypes_Response")(
            types=[self._all[n].kind if n in self._all else unset for n in request.names]
        )

    def _get(self, request: Any) -> Message:
        return message_type("rcl_interfaces/srv/GetParameters_Response")(
            values=[self._all[n].message() if n in self._all else _VALUE() for n in request.names]
        )

    def _list(self, request: Any) -> Message:
        """Names below some prefixes, at most so many dots deep; without prefixes, of all."""
        found = []
        for name in sorted(self._all):
            for prefix in request.prefixes or [""]:
                rest = name.removeprefix(f"{prefix}.") if prefix else name
                below = not prefix or rest != name or name == prefix
                if below and (request.depth == 0 or rest.count(".") < request.depth):
                    found.append(name)
                    break
        response = message_type("rcl_interfaces/srv/ListParameters_Response")()
        response.result.names = found
        response.result.prefixes = sorted({n.rpartition(".")[0] for n in found if "." in n})
        return response

    def _set(self, request: Any) -> Message:
        return message_type("rcl_interfaces/srv/SetParameters_Response")(
            results=[self._apply([one]) for one in request.parameters]
        )

    def _set_atomically(self, request: Any) -> Message:
        return message_type("rcl_interfaces/srv/SetParametersAtomically_Response")(
            result=self._apply(request.parameters)
        )

    def _apply(self, wanted: Sequence[Any]) -> Message:
        """All of it or nothing."""
        try:
            values = []
            for one in wanted:
                if one.name not in self._all:
                    known = ", ".join(sorted(self._all))
                    raise ValueError(f"there is no parameter '{one.name}'; there are: {known}")
                values.append((self._all[one.name], self._all[one.name].checked(one.value)))
        except ValueError as error:
            return _RESULT(successful=False, reason=str(error))
        for parameter, value in values:
            parameter.value = value
            parameter.changed(value)
        self._tell([parameter for parameter, _ in values])
        return _RESULT(successful=True)

    def _tell(self, changed: Sequence[Parameter]) -> None:
        event = _EVENT(node=self._node.full_name)
        event.stamp.sec, event.stamp.nanosec = divmod(time.time_ns(), 1_000_000_000)
        event.changed_parameters = [_PARAMETER(name=p.name, value=p.message()) for p in changed]
        self._events.publish(event)


def _value(message: Message) -> Any:
    name, kind = _FIELDS.get(message.type, ("", type))
    if not name:
        return None
    value = getattr(message, name)
    return tuple(float(x) for x in value) if kind is tuple else kind(value)


def _words(kind: int) -> str:
    known = kind in Kind._value2member_map_
    return Kind(kind).name.lower().replace("_", " ") if known else f"of an unknown kind, {kind}"

"""Parameters of a node, and the services that list, read and set them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING, Any

from wbc.errors import did_you_mean
from wbc.messages import Message, message_type
from wbc.ros.errors import RosError
from wbc.ros.qos import PARAMETER_EVENTS, PARAMETERS
from wbc.ros.stamp import stamp_now

if TYPE_CHECKING:
    from wbc.ros.node import Node

_VALUE = message_type("rcl_interfaces/msg/ParameterValue")
_PARAMETER = message_type("rcl_interfaces/msg/Parameter")
_DESCRIPTOR = message_type("rcl_interfaces/msg/ParameterDescriptor")
_RESULT = message_type("rcl_interfaces/msg/SetParametersResult")
_EVENT = message_type("rcl_interfaces/msg/ParameterEvent")
_FLOAT_RANGE = message_type("rcl_interfaces/msg/FloatingPointRange")
_INTEGER_RANGE = message_type("rcl_interfaces/msg/IntegerRange")


class ParameterType(IntEnum):
    """Type of a parameter's value, as in `rcl_interfaces/msg/ParameterType`."""

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


_FIELDS: dict[ParameterType, tuple[str, type]] = {
    ParameterType.BOOL: ("bool_value", bool),
    ParameterType.INTEGER: ("integer_value", int),
    ParameterType.DOUBLE: ("double_value", float),
    ParameterType.STRING: ("string_value", str),
    ParameterType.DOUBLE_ARRAY: ("double_array_value", tuple),
}


@dataclass
class NodeParameter:
    """A parameter of a node.

    Attributes:
        name: name of the parameter.
        value: bool, int, float, str or tuple of floats; the type does not change.
        description: description in one line, with the unit.
        minimum: smallest value (of each number), or None.
        maximum: largest value (of each number), or None.
        read_only: other nodes cannot set it.
        validate: called with a new value; raises `ValueError` to reject it.
        on_change: called with a new value after it was set.
    """

    name: str
    value: Any
    description: str = ""
    minimum: float | None = None
    maximum: float | None = None
    read_only: bool = False
    validate: Callable[[Any], None] = field(default=lambda _: None)
    on_change: Callable[[Any], None] = field(default=lambda _: None)

    @property
    def type(self) -> ParameterType:
        """Type of its value."""
        return next(kind for kind, (_, t) in _FIELDS.items() if type(self.value) is t)

    def parse(self, message: Message) -> Any:
        """Return the value of a `ParameterValue`, if this parameter may be set to it.

        Raises:
            ValueError: the value is rejected; the message says why.
        """
        if self.read_only:
            raise ValueError(f"{self.name} is read-only")
        value = _value(message)
        if type(self.value) is float and type(value) is int:
            value = float(value)
        elif type(self.value) is tuple and message.type == ParameterType.INTEGER_ARRAY:
            value = tuple(float(x) for x in message.integer_array_value)
        if type(value) is not type(self.value):
            raise ValueError(
                f"{self.name} is of type {_type_name(self.type)}, not {_type_name(message.type)}"
            )
        self._check(value)
        return value

    def _check(self, value: Any) -> None:
        if type(value) is tuple and len(value) != len(self.value):
            raise ValueError(f"{self.name} has {len(self.value)} numbers, not {len(value)}")
        for number in value if type(value) is tuple else (value,):
            if type(number) in (int, float):
                self._check_range(number)
        self.validate(value)

    def _check_range(self, number: float) -> None:
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        if not (math.isfinite(number) and low <= number <= high):
            raise ValueError(f"{self.name} = {number:g} is out of its range, {low:g} to {high:g}")

    def check_declaration(self) -> None:
        """Check the type and the initial value.

        Raises:
            RosError: the value has an unsupported type or is out of its range.
        """
        if type(self.value) not in {kind for _, kind in _FIELDS.values()}:
            raise RosError(
                f"parameter '{self.name}' = {self.value!r}: use a bool, int, float, str or tuple "
                "of floats"
            )
        try:
            self._check(self.value)
        except ValueError as error:
            raise RosError(f"parameter {error}") from error

    def to_message(self) -> Message:
        """Return the value as `ParameterValue`."""
        return _VALUE(type=self.type, **{_FIELDS[self.type][0]: self.value})

    def descriptor(self) -> Message:
        """Return the description as `ParameterDescriptor`."""
        descriptor = _DESCRIPTOR(
            name=self.name,
            type=self.type,
            description=self.description,
            read_only=self.read_only,
        )
        if self.minimum is not None and self.maximum is not None:
            if self.type == ParameterType.INTEGER:
                span = _INTEGER_RANGE(from_value=int(self.minimum), to_value=int(self.maximum))
                descriptor.integer_range = [span]
            else:
                span = _FLOAT_RANGE(from_value=self.minimum, to_value=self.maximum)
                descriptor.floating_point_range = [span]
        return descriptor


class ParameterServer:
    """Holds the parameters of a node and serves them to other nodes.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._all: dict[str, NodeParameter] = {}
        self._events = node.create_publisher(_EVENT, "/parameter_events", PARAMETER_EVENTS)
        for kind, callback in (
            ("DescribeParameters", self._describe),
            ("GetParameterTypes", self._types),
            ("GetParameters", self._get),
            ("ListParameters", self._list),
            ("SetParameters", self._set),
            ("SetParametersAtomically", self._set_atomically),
        ):
            name = "".join("_" + c.lower() if c.isupper() else c for c in kind)[1:]
            node.create_service(f"rcl_interfaces/srv/{kind}", f"~/{name}", callback, PARAMETERS)

    def declare(self, parameter: NodeParameter) -> NodeParameter:
        """Add a parameter; see `Node.declare_parameter`."""
        if parameter.name in self._all:
            raise RosError(f"parameter '{parameter.name}' is already declared")
        parameter.check_declaration()
        self._all[parameter.name] = parameter
        return parameter

    def get(self, name: str) -> NodeParameter:
        """Return a parameter; see `Node.get_parameter`."""
        if name not in self._all:
            raise RosError(f"parameter '{name}' is not declared{did_you_mean(name, self._all)}")
        return self._all[name]

    def _describe(self, request: Any, response: Any) -> Any:
        response.descriptors = [
            self._all[name].descriptor() if name in self._all else _DESCRIPTOR(name=name)
            for name in request.names
        ]
        return response

    def _types(self, request: Any, response: Any) -> Any:
        unset = ParameterType.NOT_SET
        response.types = [self._all[n].type if n in self._all else unset for n in request.names]
        return response

    def _get(self, request: Any, response: Any) -> Any:
        response.values = [
            self._all[n].to_message() if n in self._all else _VALUE() for n in request.names
        ]
        return response

    def _list(self, request: Any, response: Any) -> Any:
        """Names below the given prefixes, at most `depth` levels deep; all without prefixes."""
        found = []
        for name in sorted(self._all):
            for prefix in request.prefixes or [""]:
                rest = name.removeprefix(f"{prefix}.") if prefix else name
                below = not prefix or rest != name or name == prefix
                if below and (request.depth == 0 or rest.count(".") < request.depth):
                    found.append(name)
                    break
        response.result.names = found
        response.result.prefixes = sorted({n.rpartition(".")[0] for n in found if "." in n})
        return response

    def _set(self, request: Any, response: Any) -> Any:
        response.results = [self._apply([one]) for one in request.parameters]
        return response

    def _set_atomically(self, request: Any, response: Any) -> Any:
        response.result = self._apply(request.parameters)
        return response

    def _apply(self, requested: Sequence[Any]) -> Message:
        """Set all of these parameters, or none."""
        try:
            values = []
            for one in requested:
                if one.name not in self._all:
                    hint = did_you_mean(one.name, sorted(self._all))
                    raise ValueError(f"there is no parameter '{one.name}'{hint}")
                values.append((self._all[one.name], self._all[one.name].parse(one.value)))
        except ValueError as error:
            return _RESULT(successful=False, reason=str(error))
        for parameter, value in values:
            parameter.value = value
            parameter.on_change(value)
        self._publish_event([parameter for parameter, _ in values])
        return _RESULT(successful=True)

    def _publish_event(self, changed: Sequence[NodeParameter]) -> None:
        event: Any = _EVENT(node=self._node.fully_qualified_name, stamp=stamp_now())
        event.changed_parameters = [_PARAMETER(name=p.name, value=p.to_message()) for p in changed]
        self._events.publish(event)


def _value(message: Message) -> Any:
    name, kind = _FIELDS.get(message.type, ("", type))
    if not name:
        return None
    value = getattr(message, name)
    return tuple(float(x) for x in value) if kind is tuple else kind(value)


def _type_name(kind: int) -> str:
    known = kind in ParameterType._value2member_map_
    return ParameterType(kind).name.lower().replace("_", " ") if known else f"unknown ({kind})"

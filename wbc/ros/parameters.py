"""Parameters of a node, and the services that list, read and set them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from wbc.errors import did_you_mean
from wbc.messages import Message, message_type
from wbc.ros.errors import RosError
from wbc.ros.qos import SERVICES
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


#: Numbers of all types, by their names in lower case.
_TYPE_NUMBERS: dict[str, int] = {
    name.removeprefix("PARAMETER_").lower(): number
    for name, number in vars(message_type("rcl_interfaces/msg/ParameterType")).items()
    if name.startswith("PARAMETER_")
}
#: Types that a parameter can have, with the type of the value in Python.
_TYPES = {"bool": bool, "integer": int, "double": float, "string": str, "double_array": tuple}
#: Integers are accepted where numbers are expected.
_INTEGER_TYPES = {"double": "integer", "double_array": "integer_array"}


@dataclass
class NodeParameter:
    """A parameter of a node.

    Attributes:
        name: name of the parameter.
        value: bool, int, float, str or tuple of floats; the type does not change.
        description: description in one line, with the unit.
        bounds: smallest and largest value (of each number), or None.
        read_only: whether other nodes cannot set it.
        on_change: called with a new value after it was set.
    """

    name: str
    value: Any
    description: str = ""
    bounds: tuple[float, float] | None = None
    read_only: bool = False
    on_change: Callable[[Any], None] = field(default=lambda _: None)

    @property
    def type_name(self) -> str:
        """Name of its type in lower case; "not_set" if no parameter can have such a value."""
        names = (name for name, python in _TYPES.items() if type(self.value) is python)
        return next(names, "not_set")

    @property
    def type(self) -> int:
        """Number of its type, a constant of `rcl_interfaces/msg/ParameterType`."""
        return _TYPE_NUMBERS[self.type_name]

    def parse(self, message: Message) -> Any:
        """Return the value of a `ParameterValue`, if this parameter may be set to it.

        Raises:
            ValueError: the value is rejected; the text states the reason.
        """
        if self.read_only:
            raise ValueError(f"{self.name} is read-only")
        names = (name for name, number in _TYPE_NUMBERS.items() if number == message.type)
        name = next(names, f"unknown ({message.type})")
        if name == "not_set":
            raise ValueError(f"{self.name} cannot be deleted")
        if name not in (self.type_name, _INTEGER_TYPES.get(self.type_name)):
            raise ValueError(f"{self.name} is of type {self.type_name}, not {name}")
        value, python = getattr(message, f"{name}_value"), _TYPES[self.type_name]
        value = tuple(float(number) for number in value) if python is tuple else python(value)
        self.check(value)
        return value

    def check(self, value: Any) -> None:
        """Check the length and the range of a value.

        Raises:
            ValueError: the parameter may not have this value.
        """
        if type(value) is tuple and len(value) != len(self.value):
            raise ValueError(f"{self.name} has {len(self.value)} numbers, not {len(value)}")
        low, high = self.bounds or (-math.inf, math.inf)
        for number in value if type(value) is tuple else (value,):
            if type(number) in (int, float) and not (
                math.isfinite(number) and low <= number <= high
            ):
                raise ValueError(
                    f"{self.name} = {number:g} is out of its range, {low:g} to {high:g}"
                )

    def to_message(self) -> Message:
        """Return the value as `ParameterValue`."""
        fields = {} if self.value is None else {f"{self.type_name}_value": self.value}
        return _VALUE(type=self.type, **fields)

    def descriptor(self) -> Message:
        """Return the description as `ParameterDescriptor`."""
        descriptor = _DESCRIPTOR(
            name=self.name,
            type=self.type,
            description=self.description,
            read_only=self.read_only,
        )
        if self.bounds is not None:
            low, high = self.bounds
            if self.type_name == "integer":
                limits = _INTEGER_RANGE(from_value=int(low), to_value=int(high))
                descriptor.integer_range = [limits]
            else:
                descriptor.floating_point_range = [_FLOAT_RANGE(from_value=low, to_value=high)]
        return descriptor


def parameter_message(name: str, value: Any) -> Message:
    """Return a `Parameter`, whose type is that of a value of Python.

    Raises:
        RosError: no parameter can have the value.
    """
    if isinstance(value, list):
        value = tuple(float(one) if type(one) is int else one for one in value)
        if not all(type(one) is float for one in value):
            raise RosError(f"parameter '{name}': {list(value)} is not a list of numbers")
    parameter = NodeParameter(name, value)
    if parameter.type_name == "not_set":
        raise RosError(f"parameter '{name}' cannot be {value!r}")
    return _PARAMETER(name=name, value=parameter.to_message())


def parameter_value(message: Any) -> Any:
    """Return the value of a `ParameterValue`; None if it is not set."""
    names = {number: name for name, number in _TYPE_NUMBERS.items()}
    name = names.get(message.type, "not_set")
    return None if name == "not_set" else getattr(message, f"{name}_value")


class ParameterServer:
    """Holds the parameters of a node and serves them to other nodes.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._parameters: dict[str, NodeParameter] = {}
        self._events = node.create_publisher(_EVENT, "/parameter_events", SERVICES)
        for service, callback in (
            ("DescribeParameters", self._describe_parameters),
            ("GetParameterTypes", self._get_parameter_types),
            ("GetParameters", self._get_parameters),
            ("ListParameters", self._list_parameters),
            ("SetParameters", self._set_parameters),
            ("SetParametersAtomically", self._set_parameters_atomically),
        ):
            name = f"~/{callback.__name__[1:]}"
            node.create_service(f"rcl_interfaces/srv/{service}", name, callback)

    def declare(self, parameter: NodeParameter) -> NodeParameter:
        """Add a parameter; see `Node.declare_parameter`."""
        if parameter.name in self._parameters:
            raise RosError(f"parameter '{parameter.name}' is already declared")
        if parameter.type_name == "not_set":
            raise RosError(
                f"parameter '{parameter.name}' = {parameter.value!r}: use a bool, int, float, str "
                "or tuple of floats"
            )
        try:
            parameter.check(parameter.value)
        except ValueError as error:
            raise RosError(f"parameter {error}") from error
        self._parameters[parameter.name] = parameter
        return parameter

    def get(self, name: str) -> NodeParameter:
        """Return a parameter; see `Node.get_parameter`."""
        if name not in self._parameters:
            near = did_you_mean(name, sorted(self._parameters))
            raise RosError(f"there is no parameter '{name}'{near}")
        return self._parameters[name]

    def set(self, name: str, value: Any) -> None:
        """Set a parameter; see `Node.set_parameter`."""
        result: Any = self._set([parameter_message(name, value)])
        if not result.successful:
            raise RosError(f"parameter {result.reason}")

    def _requested(self, request: Any) -> list[NodeParameter]:
        """Return the parameters that a request names; those not declared have no value."""
        return [self._parameters.get(name, NodeParameter(name, None)) for name in request.names]

    def _describe_parameters(self, request: Any, response: Any) -> Any:
        response.descriptors = [parameter.descriptor() for parameter in self._requested(request)]
        return response

    def _get_parameter_types(self, request: Any, response: Any) -> Any:
        response.types = [parameter.type for parameter in self._requested(request)]
        return response

    def _get_parameters(self, request: Any, response: Any) -> Any:
        response.values = [parameter.to_message() for parameter in self._requested(request)]
        return response

    def _list_parameters(self, request: Any, response: Any) -> Any:
        """List the names below the given prefixes, at most `depth` levels deep."""

        def is_listed(name: str, prefix: str) -> bool:
            rest = name.removeprefix(f"{prefix}.") if prefix else name
            below = not prefix or rest != name or name == prefix
            return below and (request.depth == 0 or rest.count(".") < request.depth)

        prefixes = request.prefixes or [""]
        names = [n for n in sorted(self._parameters) if any(is_listed(n, p) for p in prefixes)]
        response.result.names = names
        response.result.prefixes = sorted({n.rpartition(".")[0] for n in names if "." in n})
        return response

    def _set_parameters(self, request: Any, response: Any) -> Any:
        response.results = [self._set([parameter]) for parameter in request.parameters]
        return response

    def _set_parameters_atomically(self, request: Any, response: Any) -> Any:
        response.result = self._set(request.parameters)
        return response

    def _set(self, requested: Sequence[Any]) -> Message:
        """Set all of these parameters, or none."""
        try:
            parameters = [self.get(one.name) for one in requested]
            values = [p.parse(r.value) for p, r in zip(parameters, requested, strict=True)]
        except (RosError, ValueError) as error:
            return _RESULT(successful=False, reason=str(error))
        for parameter, value in zip(parameters, values, strict=True):
            parameter.value = value
            parameter.on_change(value)
        event: Any = _EVENT(node=self._node.fully_qualified_name, stamp=stamp_now())
        event.changed_parameters = [
            _PARAMETER(name=p.name, value=p.to_message()) for p in parameters
        ]
        self._events.publish(event)
        return _RESULT(successful=True)

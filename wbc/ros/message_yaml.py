"""Messages as YAML, in the format of the `ros2` command."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.errors import MissingExtra
from wbc.messages import Message, MessageError
from wbc.messages.message import MessageT
from wbc.ros.stamp import stamp_now

_MAX_ELEMENTS = 128  # of an array


def to_yaml(value: Any) -> str:
    """Return a message, or the value of a field, as YAML.

    Long arrays are truncated, and texts of several lines are block scalars.

    Raises:
        MissingExtra: `pyyaml` is not installed.
    """
    yaml = _import_yaml()

    def represent_text(dumper: Any, text: str) -> Any:
        style = "|" if "\n" in text else None
        return dumper.represent_scalar("tag:yaml.org,2002:str", text, style)

    dumper: Any = type("MessageDumper", (yaml.SafeDumper,), {})
    dumper.add_representer(str, represent_text)
    text: str = yaml.dump(
        _plain(value), Dumper=dumper, sort_keys=False, allow_unicode=True, width=float("inf")
    )
    return text.removesuffix("...\n").rstrip("\n")


def parse_yaml(text: str) -> Any:
    """Return the value of a YAML document.

    Raises:
        MissingExtra: `pyyaml` is not installed.
        MessageError: the text is not YAML.
    """
    yaml = _import_yaml()
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise MessageError(f"'{text}' is not YAML: {' '.join(str(error).split())}") from error


def from_yaml(msg_type: type[MessageT], text: str) -> MessageT:
    """Return a message with the fields that a YAML mapping has; the others keep their defaults.

    The text `now` stands for the system time in a field of type `builtin_interfaces/msg/Time`.

    Raises:
        MissingExtra: `pyyaml` is not installed.
        MessageError: the text is not YAML, there is no such field, or a value does not fit.
    """
    message = msg_type()
    _fill(message, parse_yaml(text) or {})
    return message


def _fill(message: Message, fields: Any) -> None:
    if not isinstance(fields, dict):
        raise MessageError(
            f"{type(message).type_name} is given by its fields, e.g. "
            f"'{{{next(iter(message.__dataclass_fields__))}: …}}', not by {fields!r}"
        )
    for name, value in fields.items():
        current = getattr(message, str(name), None)
        element = message.element_type(str(name))
        if isinstance(current, Message):
            if value == "now" and type(current).type_name == "builtin_interfaces/msg/Time":
                setattr(message, name, stamp_now())
            else:
                _fill(current, value)
        elif element is not None:
            setattr(message, name, [_filled(element, one) for one in value])
        else:
            setattr(message, str(name), value)


def _filled(msg_type: type[Message], fields: Any) -> Message:
    message = msg_type()
    _fill(message, fields)
    return message


def _import_yaml() -> Any:
    try:
        import yaml
    except ImportError as error:
        raise MissingExtra("pyyaml", "ros2") from error
    return yaml


def get_field(message: Any, path: str) -> Any:
    """Return a field of a message, such as `header.frame_id` or `position[3]`.

    Raises:
        LookupError: there is no such field.
    """
    for name in path.replace("[", ".[").split("."):
        try:
            message = message[int(name[1:-1])] if name.startswith("[") else getattr(message, name)
        except (AttributeError, IndexError, ValueError, TypeError) as error:
            raise LookupError(f"there is no '{name}' in '{path}': {error}") from error
    return message


def _plain(value: Any) -> Any:
    """Return a value as dictionaries, lists, strings and numbers of Python."""
    if isinstance(value, Message):
        return {name: _plain(getattr(value, name)) for name in value.__dataclass_fields__}
    if isinstance(value, (list, tuple, np.ndarray)):
        elements = [_plain(element) for element in value[:_MAX_ELEMENTS]]
        omitted = len(value) - len(elements)
        return [*elements, f"… {omitted} more"] if omitted else elements
    return value.item() if isinstance(value, np.generic) else value

"""Messages as YAML, in the format of `ros2 topic echo`."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.errors import MissingExtra
from wbc.messages import Message

_MAX_ELEMENTS = 128  # of an array


def to_yaml(value: Any) -> str:
    """Return a message, or the value of a field, as YAML.

    Long arrays are truncated, and texts of several lines are block scalars.

    Raises:
        MissingExtra: `pyyaml` is not installed.
    """
    try:
        import yaml
    except ImportError as error:
        raise MissingExtra("pyyaml", "ros2") from error

    def represent_text(dumper: Any, text: str) -> Any:
        style = "|" if "\n" in text else None
        return dumper.represent_scalar("tag:yaml.org,2002:str", text, style)

    dumper: Any = type("MessageDumper", (yaml.SafeDumper,), {})
    dumper.add_representer(str, represent_text)
    text: str = yaml.dump(
        _plain(value), Dumper=dumper, sort_keys=False, allow_unicode=True, width=float("inf")
    )
    return text.removesuffix("...\n").rstrip("\n")


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

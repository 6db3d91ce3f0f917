"""Messages as YAML, in the format of `ros2 topic echo`."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.messages import Message

_MAX_ELEMENTS = 128  # elements of an array to print


def to_yaml(message: Message, indent: int = 0) -> str:
    """Return a message as YAML.

    Args:
        message: the message.
        indent: number of spaces before each line.
    """
    return "\n".join(_lines(message, indent))


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


def value_to_yaml(value: Any) -> str:
    """Return the value of a field as YAML."""
    if isinstance(value, Message):
        return to_yaml(value)
    if isinstance(value, (list, tuple, np.ndarray)):
        return "\n".join(_array(value, 0)) or "[]"
    return _scalar(value)


def _lines(message: Message, indent: int) -> list[str]:
    blank = " " * indent
    lines = []
    for name in message.__dataclass_fields__:
        value = getattr(message, name)
        if isinstance(value, Message):
            lines += [f"{blank}{name}:", *_lines(value, indent + 2)]
        elif isinstance(value, (list, tuple, np.ndarray)):
            array = _array(value, indent)
            lines += [f"{blank}{name}:", *array] if array else [f"{blank}{name}: []"]
        else:
            lines.append(f"{blank}{name}: {_scalar(value)}")
    return lines


def _array(values: Any, indent: int) -> list[str]:
    blank = " " * indent
    lines = []
    for value in list(values)[:_MAX_ELEMENTS]:
        if isinstance(value, Message):
            first, *rest = _lines(value, indent + 2)
            lines += [f"{blank}- {first.lstrip()}", *rest]
        else:
            lines.append(f"{blank}- {_scalar(value)}")
    if len(values) > _MAX_ELEMENTS:
        lines.append(f"{blank}- '… {len(values) - _MAX_ELEMENTS} more'")
    return lines


def _scalar(value: Any) -> str:
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (float, np.floating)):
        text = repr(float(value))
        return {"nan": ".nan", "inf": ".inf", "-inf": "-.inf"}.get(text, text)
    return str(value)


def _quoted(text: str) -> str:
    plain = text and text.replace("_", "").replace("/", "").isalnum() and not text[0].isdigit()
    if plain and text.lower() not in ("true", "false", "null", "yes", "no", "on", "off"):
        return text
    if "\n" in text:
        return "|-\n" + "\n".join("  " + line for line in text.splitlines())
    return "'" + text.replace("'", "''") + "'"

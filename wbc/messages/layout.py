"""The layout of serialized messages, by which many are read or written as columns."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from wbc.messages.message import Message
from wbc.messages.typestore import number_dtype, typestore


class _Number(NamedTuple):
    """A number, or an array of numbers, in a message."""

    path: str
    holder: Message
    field: str
    dtype: np.dtype[Any]


def message_layout(message: Message) -> np.dtype[np.void]:
    """Return the layout of a serialized message as a structured type.

    It has a field for each number and array of numbers, named by its path, for example
    "pose.position.x" or "transforms[2].header.stamp.sec", and one for each nested message that
    consists of numbers of one type side by side, for example "pose" of shape (7,). The layout
    holds for all messages whose strings and sequences have the same lengths.

    Example:
        >>> twist = message_type("geometry_msgs/msg/Twist")()
        >>> twist.linear.y = 2.0
        >>> np.frombuffer(twist.encode(), message_layout(twist))["linear"]
        array([[0., 2., 0.]])
    """
    probes = []
    for byte in (b"\x00", b"\x3f"):  # the bytes that differ are those of the numbers, in order
        probe = copy.deepcopy(message)
        numbers = list(_numbers(probe))
        for _, holder, field, dtype in numbers:
            setattr(holder, field, np.frombuffer(byte * dtype.itemsize, dtype)[0])
        probes.append(np.frombuffer(probe.encode(), np.uint8))
    offsets = np.flatnonzero(probes[0] != probes[1])
    fields: dict[str, tuple[Any, int] | None] = {}
    start = 0
    for path, _, _, dtype in numbers:
        steps = path.split(".")
        for depth in range(1, len(steps) + 1):
            name = ".".join(steps[:depth])
            part = (dtype, int(offsets[start]))
            fields[name] = _joined(fields[name], part) if name in fields else part
        start += dtype.itemsize
    known = {name: field for name, field in fields.items() if field is not None}
    forms, places = [form for form, _ in known.values()], [place for _, place in known.values()]
    return np.dtype(
        {"names": list(known), "formats": forms, "offsets": places, "itemsize": len(probes[0])}
    )


def _joined(first: tuple[Any, int] | None, second: tuple[Any, int]) -> tuple[Any, int] | None:
    """Return the array that two fields side by side are together; None if they are not."""
    if first is None:
        return None
    (one, offset), (other, after) = first, second
    size = after - offset + other.itemsize
    if one.base != other.base or size != one.itemsize + other.itemsize:
        return None
    return np.dtype((one.base, (size // one.base.itemsize,))), offset


def _numbers(message: Message, prefix: str = "") -> Iterator[_Number]:
    """Iterate over the numbers of a message, in the order in which they are serialized."""
    for field, desc in typestore().fielddefs[type(message).type_name][1]:
        value, path = getattr(message, field), prefix + field
        if isinstance(value, Message):
            yield from _numbers(value, f"{path}.")
        elif isinstance(value, np.ndarray):
            if value.size:
                yield _Number(path, message, field, np.dtype((value.dtype, value.shape)))
        elif isinstance(value, list):
            for index, element in enumerate(value):
                if isinstance(element, Message):
                    yield from _numbers(element, f"{path}[{index}].")
        elif not isinstance(value, str):
            yield _Number(path, message, field, number_dtype(str(desc[1][0])))

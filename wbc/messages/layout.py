"""Where the numbers of a serialized message are: many messages are read or written as columns."""

from __future__ import annotations

import copy
import math
from collections import defaultdict
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
    shape: tuple[int, ...]

    @property
    def size(self) -> int:
        return math.prod(self.shape) * self.dtype.itemsize

    def fill(self, byte: int) -> None:
        """Set all bytes of the number."""
        values = np.frombuffer(bytes([byte]) * self.size, self.dtype)
        setattr(self.holder, self.field, values if self.shape else values[0])


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
    for byte in (0x00, 0x3F):  # the bytes that differ are those of the numbers, in their order
        probe = copy.deepcopy(message)
        numbers = [number for number in _numbers(probe) if number.size]
        for number in numbers:
            number.fill(byte)
        probes.append(np.frombuffer(probe.encode(), np.uint8))
    offsets = np.flatnonzero(probes[0] != probes[1]).tolist()
    parts: dict[str, list[tuple[int, _Number]]] = defaultdict(list)
    start = 0
    for number in numbers:
        steps = number.path.split(".")
        for depth in range(len(steps)):
            parts[".".join(steps[: depth + 1])].append((offsets[start], number))
        start += number.size
    fields: dict[str, tuple[int, Any]] = {}
    for path, found in parts.items():
        (first, number), (last, end) = found[0], found[-1]
        size = sum(one.size for _, one in found)
        if size == last + end.size - first and all(n.dtype == number.dtype for _, n in found):
            shape = number.shape if len(found) == 1 else (size // number.dtype.itemsize,)
            fields[path] = (first, (number.dtype, shape))
    return np.dtype(
        {
            "names": list(fields),
            "formats": [form for _, form in fields.values()],
            "offsets": [offset for offset, _ in fields.values()],
            "itemsize": len(probes[0]),
        }
    )


def _numbers(message: Message, prefix: str = "") -> Iterator[_Number]:
    """Iterate over the numbers of a message, in the order in which they are serialized."""
    for field, desc in typestore().fielddefs[message.type_name][1]:
        value, path = getattr(message, field), prefix + field
        if isinstance(value, Message):
            yield from _numbers(value, f"{path}.")
        elif isinstance(value, np.ndarray):
            yield _Number(path, message, field, value.dtype, value.shape)
        elif isinstance(value, list):
            for index, element in enumerate(value):
                if isinstance(element, Message):
                    yield from _numbers(element, f"{path}[{index}].")
        elif not isinstance(value, str):
            yield _Number(path, message, field, number_dtype(str(desc[1][0])), ())

"""A message that is serialized once, of which many copies with other numbers are made at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from wbc.messages import Message, message_layout

_NS = 1_000_000_000  # per second


class MessageTemplate:
    """A message with everything but the numbers.

    Args:
        message: The message; each `stamp` in it is filled in.
    """

    def __init__(self, message: Message) -> None:
        self._serialized = np.frombuffer(message.encode(), np.uint8)
        self._layout = message_layout(message)
        self._stamps = [path for path in self._layout.names or () if path.endswith("stamp.sec")]
        self._elements: dict[str, tuple[np.dtype[Any], np.ndarray]] = {}

    def fill(self, stamps: np.ndarray, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return serialized messages, one per row, uint8, shape (n, size).

        Args:
            stamps: Times of the messages, ns, shape (n,).
            values: Values by the paths of their fields, shape (n, k) or (n,). A field may be a
                message of numbers, such as a pose (see `message_layout`). The values of a field
                of all elements of a sequence, path "poses[{}].position", have shape (n, m, k).
        """
        data = np.empty((len(stamps), len(self._serialized)), np.uint8)
        data[:] = self._serialized
        messages = data.view(self._layout)[:, 0]
        for path, one in values.items():
            if "{}" in path:
                self._fill_elements(data, path, one)
            else:
                field = messages[path]
                field[:] = one.reshape(field.shape)
        seconds, nanoseconds = np.divmod(stamps, _NS)
        for path in self._stamps:
            messages[path] = seconds
            messages[f"{path[:-3]}nanosec"] = nanoseconds
        return data

    def _fill_elements(self, data: np.ndarray, path: str, values: np.ndarray) -> None:
        """Fill in a field of all elements of a sequence, at once: there may be many."""
        count = values.shape[1]
        if count == 0:
            return
        if path not in self._elements:
            fields = self._layout.fields
            assert fields is not None
            found = [fields[path.format(index)][:2] for index in range(count)]
            field = found[0][0]
            places = np.array([place for _, place in found])[:, None] + np.arange(field.itemsize)
            self._elements[path] = field.base, places.ravel()
        dtype, places = self._elements[path]
        numbers = np.ascontiguousarray(values, dtype).reshape(len(data), -1)
        data[:, places] = numbers.view(np.uint8)

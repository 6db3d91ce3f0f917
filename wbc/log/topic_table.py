"""The messages of one topic of a log."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from wbc.log.errors import LogError
from wbc.messages import Message, MessageError, Template, message_type
from wbc.messages.cdr import FieldLocation

_BLOCK = 256  # messages whose numbers are extracted together


class TopicTable:
    """The messages of one topic, stored as numbers where possible.

    Of messages without lists of messages only the numbers are kept: three quarters of a joint
    state are names. Others are kept whole.

    Args:
        topic: Name of the topic.
        type_name: Type of its messages.
    """

    def __init__(self, topic: str, type_name: str) -> None:
        self.topic = topic
        self.type_name = type_name
        self._stamps = array("q")
        self._messages: list[bytes] = []  # whole, or not yet extracted
        self._rows: list[np.ndarray] = []
        self._first = b""
        self._keeps_whole = True
        self._places: dict[tuple[str, int], slice] = {}  # columns of each field of a size
        self._layouts: dict[int, list[tuple[FieldLocation, slice]]] = {}  # by size of a message

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self._stamps)

    def add(self, stamp: int, data: bytes) -> None:
        """Add a message.

        Args:
            stamp: Log time, ns.
            data: Serialized message.
        """
        if not self._stamps:
            self._begin(data)
        self._stamps.append(stamp)
        self._messages.append(data)
        if len(self._messages) >= _BLOCK and not self._keeps_whole:
            self._rows.append(self._extract(self._messages))
            self._messages.clear()

    @property
    def first(self) -> Message:
        """Return the first message."""
        return self._decode(self._first)

    def stamps(self) -> np.ndarray:
        """Return the log times of the messages, ns, shape (n,)."""
        return np.array(self._stamps, np.int64)

    def messages(self) -> list[Message]:
        """Return the messages of a topic whose messages are kept whole.

        Raises:
            LogError: Only the numbers of the messages are kept.
        """
        if not self._keeps_whole:
            raise LogError(
                f"only the numbers of '{self.topic}' are kept: read its fields with numbers()"
            )
        return [self._decode(data) for data in self._messages]

    def numbers(self, field: str) -> np.ndarray:
        """Return the values of a field, shape (n, k); NaN where a message has no such field.

        Raises:
            LogError: The messages have no numeric field of that name.
        """
        chosen = np.array(
            [
                column
                for (path, _), columns in self._places.items()
                if path == field or path.startswith((field + ".", field + "["))
                for column in range(columns.start, columns.stop)
            ]
        )
        if not len(chosen):
            raise LogError(
                f"'{self.topic}' ({self.type_name}) has no numeric field '{field}'; it has: "
                + ", ".join([path for path, _ in self._places][:12])
            )
        blocks = [*self._rows, self._extract(self._messages)]
        return np.concatenate([block[:, chosen] for block in blocks])

    def _begin(self, data: bytes) -> None:
        """Lay out the columns of the table by its first message."""
        self._first = data
        try:
            message = self.first
        except MessageError:  # a type that the library does not define
            return
        self._keeps_whole = _has_lists_of_messages(message)
        start = 0
        for place in Template(message).locations:
            self._places[place.path, place.count] = slice(start, start + place.count)
            start += place.count

    def _extract(self, messages: Sequence[bytes]) -> np.ndarray:
        """Return the numbers of messages in the order of the columns, shape (n, m)."""
        sizes = np.array([len(message) for message in messages], int)
        rows = np.full((len(messages), sum(count for _, count in self._places)), np.nan)
        for size in np.unique(sizes).tolist():
            chosen = np.flatnonzero(sizes == size)
            block = np.frombuffer(b"".join([messages[k] for k in chosen]), np.uint8)
            block = block.reshape(-1, size)
            for place, columns in self._layout(messages[chosen[0]]):
                stop = place.offset + place.count * place.dtype.itemsize
                numbers = np.ascontiguousarray(block[:, place.offset : stop]).view(place.dtype)
                rows[chosen, columns] = numbers
        return rows

    def _layout(self, data: bytes) -> list[tuple[FieldLocation, slice]]:
        """Return where in messages of this one's size the numbers of which columns lie."""
        if len(data) not in self._layouts:
            self._layouts[len(data)] = [
                (place, self._places[place.path, place.count])
                for place in Template(self._decode(data)).locations
                if (place.path, place.count) in self._places
            ]
        return self._layouts[len(data)]

    def _decode(self, data: bytes) -> Message:
        return message_type(self.type_name).decode(data)


def _has_lists_of_messages(message: Any) -> bool:
    """Return whether a message has a list of other than strings, at any depth."""
    return any(
        (isinstance(value, list) and not (value and isinstance(value[0], str)))
        or (is_dataclass(value) and _has_lists_of_messages(value))
        for value in _values(message)
    )


def _values(message: Any) -> Iterator[Any]:
    for field in fields(message):
        yield getattr(message, field.name)

"""The messages of one topic of a log."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wbc.log.errors import LogError
from wbc.messages import Message, MessageError, Template, get_definition, message_type
from wbc.messages.cdr import FieldLocation
from wbc.messages.definition import Multiplicity


class Table:
    """The messages of one topic, stored as numbers where possible.

    If every message has the same structure, only the numbers are kept: three quarters of a joint
    state are names. Messages whose type contains arrays of messages are kept whole.

    Args:
        topic: Name of the topic.
        type_name: Type of its messages.
    """

    def __init__(self, topic: str, type_name: str) -> None:
        self.topic = topic
        self.type_name = type_name
        self._stamps: list[np.ndarray] = []
        self._whole: list[bytes] = []
        self._numbers: list[np.ndarray] = []
        self._first = b""
        self._places: list[FieldLocation] = []
        try:
            self._keeps_whole = _has_arrays_of_messages(type_name)
        except MessageError:  # a type that the library does not define
            self._keeps_whole = True

    def __len__(self) -> int:
        """Return the number of messages."""
        return sum(len(stamps) for stamps in self._stamps)

    def add(self, stamps: Sequence[int], messages: Sequence[bytes]) -> None:
        """Add messages.

        Args:
            stamps: Log times, ns.
            messages: Serialized messages.
        """
        if not self._stamps:
            self._first = messages[0]
        self._stamps.append(np.array(stamps, np.int64))
        if self._keeps_whole:
            self._whole += messages
        else:
            self._numbers.append(self._rows(messages))

    @property
    def first(self) -> Message:
        """Return the first message."""
        return message_type(self.type_name).decode(self._first)

    def stamps(self) -> np.ndarray:
        """Return the log times of the messages, ns, shape (n,)."""
        return np.concatenate(self._stamps)

    def messages(self) -> list[Message]:
        """Return the messages of a topic whose messages are kept whole.

        Raises:
            LogError: Only the numbers of the messages are kept.
        """
        if not self._keeps_whole:
            raise LogError(
                f"only the numbers of '{self.topic}' are kept: read its fields with numbers()"
            )
        kind = message_type(self.type_name)
        return [kind.decode(data) for data in self._whole]

    def numbers(self, field: str) -> np.ndarray:
        """Return the values of a field, shape (n, k).

        Raises:
            LogError: The messages have no numeric field of that name.
        """
        if self._whole and not self._numbers:
            self._numbers = [self._rows(self._whole)]
        start = 0
        chosen: list[int] = []
        for place in self._places:
            if place.path == field or place.path.startswith((field + ".", field + "[")):
                chosen += range(start, start + place.count)
            start += place.count
        if not chosen:
            raise LogError(
                f"'{self.topic}' ({self.type_name}) has no numeric field '{field}'; it has: "
                + ", ".join(place.path for place in self._places[:12])
            )
        return np.asarray(np.concatenate(self._numbers)[:, chosen])

    def _rows(self, messages: Sequence[bytes]) -> np.ndarray:
        """Return all numbers of the messages in the order of `_places`, shape (n, m)."""
        if not self._places:
            self._places = Template(self.first).locations
        size = len(self._first)
        rows = np.full((len(messages), sum(place.count for place in self._places)), np.nan)
        alike = np.array([len(message) == size for message in messages])
        block = np.frombuffer(b"".join(m for m in messages if len(m) == size), np.uint8)
        block = block.reshape(-1, size)
        start = 0
        for place in self._places:
            stop = place.offset + place.count * place.dtype.itemsize
            numbers = np.ascontiguousarray(block[:, place.offset : stop]).view(place.dtype)
            rows[alike, start : start + place.count] = numbers
            start += place.count
        for k in np.flatnonzero(~alike):
            rows[k] = self._row(messages[k])
        return rows

    def _row(self, data: bytes) -> np.ndarray:
        """Return the numbers of a message of another size, for example with a longer string."""
        template = Template(message_type(self.type_name).decode(data))
        there = {place.path: place.count for place in template.locations}
        parts = [
            template.view(place.path)
            if there.get(place.path) == place.count
            else np.full(place.count, np.nan)
            for place in self._places
        ]
        return np.concatenate(parts)


def _has_arrays_of_messages(type_name: str) -> bool:
    return any(
        field.nested
        and (field.multiplicity is not Multiplicity.ONE or _has_arrays_of_messages(field.type))
        for field in get_definition(type_name).fields
    )

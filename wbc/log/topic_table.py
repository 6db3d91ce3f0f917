"""The messages of one topic of a log."""

from __future__ import annotations

from array import array
from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from wbc.log.errors import LogError
from wbc.messages import Message, message_layout, message_type

_BLOCK = 512  # messages


class _SameSize:
    """Messages of one size. What those of a block have in common is stored once."""

    def __init__(self) -> None:
        self._indices = array("q")
        # First message, offsets of the bytes that differ, and the values of these bytes.
        self._packed: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        self._recent: list[bytes] = []

    def add(self, index: int, data: bytes) -> None:
        """Add a message."""
        self._indices.append(index)
        self._recent.append(data)
        if len(self._recent) == _BLOCK:
            rows = _rows(self._recent)
            differing = np.flatnonzero((rows != rows[0]).any(axis=0))
            self._packed.append((rows[0].copy(), differing, rows.take(differing, axis=1)))
            self._recent.clear()

    @property
    def first(self) -> bytes:
        """The first message."""
        return self._packed[0][0].tobytes() if self._packed else self._recent[0]

    def blocks(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield the messages' indices in their topic, shape (n,), and bytes, shape (n, size)."""
        indices = np.array(self._indices)
        for block, (first, differing, values) in enumerate(self._packed):
            rows = np.tile(first, (_BLOCK, 1))
            rows[:, differing] = values
            yield indices[block * _BLOCK :][:_BLOCK], rows
        if self._recent:
            yield indices[-len(self._recent) :], _rows(self._recent)


def _rows(messages: list[bytes]) -> np.ndarray:
    return np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), len(messages[0]))


class TopicTable:
    """The messages of one topic.

    Args:
        topic: Name of the topic.
        type_name: Type of its messages.

    Attributes:
        topic: Name of the topic.
        type_name: Type of its messages.
    """

    def __init__(self, topic: str, type_name: str) -> None:
        self.topic = topic
        self.type_name = type_name
        self._stamps = array("q")
        self._sizes: defaultdict[int, _SameSize] = defaultdict(_SameSize)

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self._stamps)

    def add(self, stamp: int, data: bytes) -> None:
        """Add a message.

        Args:
            stamp: Log time, ns.
            data: Serialized message.
        """
        self._sizes[len(data)].add(len(self), data)
        self._stamps.append(stamp)

    @property
    def first(self) -> Message:
        """The first message."""
        return message_type(self.type_name).decode(next(iter(self._sizes.values())).first)

    @property
    def stamps(self) -> np.ndarray:
        """Log times of the messages, ns, shape (n,)."""
        return np.array(self._stamps, np.int64)

    def message(self, index: int) -> Message:
        """Return the message with an index, without decoding the others."""
        for alike in self._sizes.values():
            for indices, rows in alike.blocks():
                place = np.flatnonzero(indices == index)
                if place.size:
                    return message_type(self.type_name).decode(rows[place[0]])
        raise IndexError(index)

    def messages(self) -> list[Message]:
        """Return the messages."""
        kind = message_type(self.type_name)
        found = {
            index: kind.decode(row)
            for alike in self._sizes.values()
            for block in alike.blocks()
            for index, row in zip(*block, strict=True)
        }
        return [found[index] for index in range(len(self))]

    def numbers(self, field: str) -> np.ndarray:
        """Return the values of a field, shape (n, k); NaN where a message has not k of them.

        Args:
            field: Field path, for example "position", "pose.pose" or "transforms[0].transform".

        Raises:
            LogError: The messages have no numeric field of that name.
        """
        kind = message_type(self.type_name)
        found: np.ndarray | None = None
        for alike in self._sizes.values():  # messages of one size have one layout
            layout = message_layout(kind.decode(alike.first))
            if field not in (layout.names or ()):
                continue
            for indices, rows in alike.blocks():
                # What follows the numbers is padding, which other writers of logs keep.
                numbers = np.ascontiguousarray(rows[:, : layout.itemsize])
                values = numbers.view(layout)[field].reshape(len(rows), -1)
                if found is None:
                    found = np.full((len(self), values.shape[1]), np.nan)
                if values.shape[1] == found.shape[1]:
                    found[indices] = values
        if found is None:
            known = message_layout(self.first).names or ()
            raise LogError(
                f"'{self.topic}' ({self.type_name}) has no numeric field '{field}'; it has: "
                + ", ".join(known[:12])
            )
        return found

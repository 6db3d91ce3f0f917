"""The messages of one topic of a log."""

from __future__ import annotations

from array import array

import numpy as np

from wbc.log.errors import LogError
from wbc.messages import Message, message_layout, message_type


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
        self._messages: list[bytes] = []

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self._stamps)

    def add(self, stamp: int, data: bytes) -> None:
        """Add a message.

        Args:
            stamp: Log time, ns.
            data: Serialized message.
        """
        self._stamps.append(stamp)
        self._messages.append(data)

    @property
    def first(self) -> Message:
        """The first message."""
        return message_type(self.type_name).decode(self._messages[0])

    @property
    def stamps(self) -> np.ndarray:
        """Log times of the messages, ns, shape (n,)."""
        return np.array(self._stamps, np.int64)

    def messages(self) -> list[Message]:
        """Return the messages."""
        kind = message_type(self.type_name)
        return [kind.decode(data) for data in self._messages]

    def numbers(self, field: str) -> np.ndarray:
        """Return the values of a field, shape (n, k); NaN where a message has not k of them.

        Args:
            field: Field path, for example "position", "pose.pose" or "transforms[0].transform".

        Raises:
            LogError: The messages have no numeric field of that name.
        """
        kind = message_type(self.type_name)
        sizes = np.array([len(data) for data in self._messages])
        rows: np.ndarray | None = None
        for size in dict.fromkeys(sizes.tolist()):  # messages of one size have one layout
            alike = np.flatnonzero(sizes == size)
            layout = message_layout(kind.decode(self._messages[alike[0]]))
            if field in (layout.names or ()):
                data = b"".join([self._messages[k] for k in alike])
                values = np.frombuffer(data, layout)[field].reshape(len(alike), -1)
                if rows is None:
                    rows = np.full((len(sizes), values.shape[1]), np.nan)
                if values.shape[1] == rows.shape[1]:
                    rows[alike] = values
        if rows is None:
            known = message_layout(self.first).names or ()
            raise LogError(
                f"'{self.topic}' ({self.type_name}) has no numeric field '{field}'; it has: "
                + ", ".join(known[:12])
            )
        return rows

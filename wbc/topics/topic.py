"""Topics made from ticks."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from wbc.messages import Message
from wbc.topics.batch import TickBatch


class MessageBlock(NamedTuple):
    """Serialized messages of one topic that have one size.

    Attributes:
        ticks: Index of the record of each message in its batch, ascending, shape (n,).
        data: One message per row, CDR, uint8, shape (n, size).
    """

    ticks: np.ndarray
    data: np.ndarray

    @staticmethod
    def of(tick: int, data: bytes) -> MessageBlock:
        """Return a block of one message."""
        return MessageBlock(np.array([tick]), np.frombuffer(data, np.uint8)[None, :])


class MessageTopic(ABC):
    """A topic that encodes ticks as messages.

    Attributes:
        name: Name of the topic, without a leading slash.
        type_name: Type of its messages.
    """

    def __init__(self, name: str, type_name: str) -> None:
        self.name, self.type_name = name, type_name

    @abstractmethod
    def messages(self, batch: TickBatch) -> list[MessageBlock]:
        """Return the messages of a batch of ticks; those of each block are in order of time."""


class LatchedTopic(MessageTopic):
    """A topic with a single message, which late subscribers receive, too.

    Attributes:
        data: The message, CDR.
    """

    def __init__(self, name: str, message: Message) -> None:
        super().__init__(name, type(message).type_name)
        self.data = message.encode()
        self._sent = False

    def messages(self, batch: TickBatch) -> list[MessageBlock]:
        """Return the message with the first tick; see `MessageTopic.messages`."""
        if self._sent or not len(batch):
            return []
        self._sent = True
        return [MessageBlock.of(0, self.data)]


def topic_name(*parts: str) -> str:
    """Join parts to a topic name; characters that ROS does not allow become underscores."""
    return "/".join(re.sub(r"[^A-Za-z0-9_]", "_", part).strip("_") or "_" for part in parts)

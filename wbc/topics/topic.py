"""Topics made from ticks."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from typing import NamedTuple

from wbc.messages import Message
from wbc.topics.batch import TickBatch


class TopicMessage(NamedTuple):
    """One message of a topic.

    Attributes:
        tick: Index of the record in its batch.
        data: Message, CDR.
    """

    tick: int
    data: bytes


class MessageTopic(ABC):
    """A topic that encodes ticks as messages.

    Attributes:
        name: Name of the topic, without a leading slash.
        type_name: Type of its messages.
    """

    def __init__(self, name: str, type_name: str) -> None:
        self.name, self.type_name = name, type_name

    @abstractmethod
    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """Return the messages of a batch of ticks, in order of time."""


class LatchedTopic(MessageTopic):
    """A topic with a single message, which late subscribers receive, too.

    Attributes:
        data: The message, CDR.
    """

    def __init__(self, name: str, message: Message) -> None:
        super().__init__(name, message.type_name)
        self.data = message.encode()
        self._sent = False

    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """Return the message with the first tick; see `MessageTopic.messages`."""
        if self._sent or not len(batch):
            return []
        self._sent = True
        return [TopicMessage(0, self.data)]


def topic_name(*parts: str) -> str:
    """Join parts to a topic name; characters that ROS does not allow become underscores."""
    return "/".join(re.sub(r"[^A-Za-z0-9_]", "_", part).strip("_") or "_" for part in parts)

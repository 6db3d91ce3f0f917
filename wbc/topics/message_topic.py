"""The base class of topics made from ticks."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from typing import NamedTuple

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
        latched: Whether late subscribers receive its single message.
    """

    name: str
    type_name: str
    latched: bool = False

    @abstractmethod
    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """Return the messages of a batch of ticks, in order of time."""


def topic_name(*parts: str) -> str:
    """Join parts to a topic name; characters that ROS does not allow become underscores."""
    return "/".join(re.sub(r"[^A-Za-z0-9_]", "_", part).strip("_") or "_" for part in parts)

"""The base of every topic that is made of ticks."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from typing import NamedTuple

from wbc.topics.batch import TickBatch


class TopicMessage(NamedTuple):
    """One message of a topic.

    Attributes:
        tick: number of the record in its batch.
        data: CDR.
    """

    tick: int
    data: bytes


class MessageTopic(ABC):
    """Makes messages of ticks.

    Attributes:
        name: of the topic, without a leading slash.
        type_name: of its messages.
        latched: one message at the beginning, for everybody who comes later.
    """

    name: str
    type_name: str
    latched: bool = False

    @abstractmethod
    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """Return the messages of a batch of ticks, in the order of time."""


def topic_name(*parts: str) -> str:
    """Return a topic's name of parts; what ROS does not allow in names becomes an underscore."""
    return "/".join(re.sub(r"[^A-Za-z0-9_]", "_", part).strip("_") or "_" for part in parts)

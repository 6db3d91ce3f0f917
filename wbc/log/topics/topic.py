"""The base of every topic."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from typing import NamedTuple

from wbc.log.topics.block import Block


class TopicMessage(NamedTuple):
    """One message of a topic.

    Attributes:
        tick: number of the record in its block.
        data: CDR.
    """

    tick: int
    data: bytes


class Topic(ABC):
    """Makes messages of ticks.

    Attributes:
        name: of the topic.
        type_name: of its messages.
        latched: one message at the beginning, for everybody who comes later.
    """

    name: str
    type_name: str
    latched: bool = False

    @abstractmethod
    def messages(self, block: Block) -> list[TopicMessage]:
        """The messages of a block of ticks, in the order of time."""


def topic_name(*parts: str) -> str:
    """A topic's name of parts; what ROS does not allow in names becomes an underscore."""
    return "/" + "/".join(re.sub(r"[^A-Za-z0-9_]", "_", part).strip("_") or "_" for part in parts)

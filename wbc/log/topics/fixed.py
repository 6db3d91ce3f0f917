"""Topics of which only numbers change from message to message."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from wbc.log.topics.block import Block
from wbc.log.topics.topic import Topic, TopicMessage
from wbc.messages import Message, Template

Numbers = Callable[[Block], np.ndarray]


class FixedTopic(Topic):
    """A template that is filled column by column for a whole block of ticks.

    Args:
        name: of the topic.
        message: as it is but for the numbers; every `stamp` in it gets the time.
        columns: field of the message -> its numbers, (n, k) or (n,), of a block. A field may
            be a message of numbers, such as a pose.
        where: (n,) which ticks have a message; all when left out.
    """

    def __init__(
        self,
        name: str,
        message: Message,
        columns: Mapping[str, Numbers],
        where: Callable[[Block], np.ndarray] | None = None,
    ) -> None:
        self.name = name
        self.type_name = message.type_name
        self._template = template = Template(message)
        self._columns = [(template.locate(path), numbers) for path, numbers in columns.items()]
        self._where = where
        self._stamps = [
            place
            for place in template.locations
            if place.path.endswith(("stamp.sec", "stamp.nanosec"))
        ]

    def messages(self, block: Block) -> list[TopicMessage]:
        """See `Topic.messages`."""
        chosen = np.arange(len(block))
        if self._where is not None:
            chosen = np.flatnonzero(self._where(block))
            if not chosen.size:
                return []
        rows = self._template.rows(len(chosen))
        for place, numbers in self._columns:
            values = numbers(block)[chosen].reshape(len(chosen), place.count)
            stop = place.offset + place.count * place.dtype.itemsize
            rows[:, place.offset : stop] = np.ascontiguousarray(values, place.dtype).view(np.uint8)
        seconds, nanoseconds = np.divmod(block.stamps[chosen], 1_000_000_000)
        for place in self._stamps:
            part = seconds if place.path.endswith(".sec") else nanoseconds
            column = np.ascontiguousarray(part, place.dtype).view(np.uint8).reshape(-1, 4)
            rows[:, place.offset : place.offset + 4] = column
        data, size = rows.tobytes(), rows.shape[1]
        return [
            TopicMessage(
                int(index), self._finish(block, int(index), data[k * size : (k + 1) * size])
            )
            for k, index in enumerate(chosen)
        ]

    def _finish(self, block: Block, index: int, data: bytes) -> bytes:
        """The last word on a message."""
        return data

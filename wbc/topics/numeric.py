"""Topics whose messages differ only in their numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from wbc.messages import Message, Template
from wbc.topics.batch import TickBatch
from wbc.topics.message_topic import MessageTopic, TopicMessage

Columns = Callable[[TickBatch], np.ndarray]


class NumericTopic(MessageTopic):
    """A topic whose message is serialized once and then filled column by column for each batch.

    Args:
        name: Name of the topic.
        message: Message with everything but the numbers; each `stamp` in it is filled in.
        columns: Maps each field of the message to a function that returns its values for a
            batch, shape (n, k) or (n,). A field may be a message of numbers, such as a pose.
        where: Function that returns a mask of the ticks of a batch with a message, shape (n,);
            all by default.
    """

    def __init__(
        self,
        name: str,
        message: Message,
        columns: Mapping[str, Columns],
        where: Callable[[TickBatch], np.ndarray] | None = None,
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

    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """Return the messages of a batch; see `MessageTopic.messages`."""
        chosen = np.arange(len(batch))
        if self._where is not None:
            chosen = np.flatnonzero(self._where(batch))
            if not chosen.size:
                return []
        rows = self._template.rows(len(chosen))
        for place, numbers in self._columns:
            values = numbers(batch)[chosen].reshape(len(chosen), place.count)
            stop = place.offset + place.count * place.dtype.itemsize
            rows[:, place.offset : stop] = np.ascontiguousarray(values, place.dtype).view(np.uint8)
        seconds, nanoseconds = np.divmod(batch.stamps[chosen], 1_000_000_000)
        for place in self._stamps:
            part = seconds if place.path.endswith(".sec") else nanoseconds
            column = np.ascontiguousarray(part, place.dtype).view(np.uint8).reshape(-1, 4)
            rows[:, place.offset : place.offset + 4] = column
        data, size = rows.tobytes(), rows.shape[1]
        return [
            TopicMessage(
                int(index), self._finish(batch, int(index), data[k * size : (k + 1) * size])
            )
            for k, index in enumerate(chosen)
        ]

    def _finish(self, batch: TickBatch, index: int, data: bytes) -> bytes:
        """Return the final bytes of a message."""
        return data

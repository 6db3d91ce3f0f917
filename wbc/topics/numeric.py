"""Topics whose messages differ only in their numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from wbc.messages import Message, message_layout
from wbc.topics.batch import TickBatch
from wbc.topics.topic import MessageTopic, TopicMessage

Values = Callable[[TickBatch], Mapping[str, np.ndarray]]
_NS = 1_000_000_000  # per second


class NumericTopic(MessageTopic):
    """A topic whose message is serialized once and then filled column by column for each batch.

    Ticks at which all its values are NaN have no message.

    Args:
        name: Name of the topic.
        message: Message with everything but the numbers; each `stamp` in it is filled in.
        values: Returns the values of a batch by the paths of their fields, shape (n, k) or (n,). A
            field may be a message of numbers, such as a pose (see `message_layout`).
        period: Period of the messages, s; 0 publishes every tick.
    """

    def __init__(self, name: str, message: Message, values: Values, period: float = 0.0) -> None:
        super().__init__(name, message.type_name)
        self._serialized = np.frombuffer(message.encode(), np.uint8)
        self._layout = message_layout(message)
        self._stamps = [path for path in self._layout.names or () if path.endswith("stamp.sec")]
        self._values = values
        self._period = round(1e9 * period)
        self._due = 0

    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """Return the messages of a batch; see `MessageTopic.messages`."""
        ticks = self._ticks_due(batch)
        if not len(ticks):
            return []
        batch = batch.select(ticks)
        values = self._values(batch)
        numbers = [one.reshape(len(ticks), -1) for one in values.values()]
        known = ~np.isnan(np.concatenate(numbers, axis=1)).all(axis=1)
        if not known.all():
            ticks, batch = ticks[known], batch.select(np.flatnonzero(known))
            values = {path: one[known] for path, one in values.items()}
        data = np.tile(self._serialized, (len(ticks), 1))
        messages = data.view(self._layout)[:, 0]
        for path, one in values.items():
            field = messages[path]
            field[:] = one.reshape(field.shape)
        seconds, nanoseconds = np.divmod(batch.stamps, _NS)
        for path in self._stamps:
            messages[path] = seconds
            messages[f"{path[:-3]}nanosec"] = nanoseconds
        return [TopicMessage(k, row.tobytes()) for k, row in zip(ticks.tolist(), data, strict=True)]

    def _ticks_due(self, batch: TickBatch) -> np.ndarray:
        """Return the indices of the ticks of a batch that are due."""
        if not self._period:
            return np.arange(len(batch))
        due = []
        for tick, stamp in enumerate(batch.stamps.tolist()):
            if stamp >= self._due:
                due.append(tick)
                self._due = stamp - stamp % self._period + self._period
        return np.array(due, int)

"""Topics whose messages differ only in their numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from wbc.messages import Message
from wbc.topics.batch import TickBatch
from wbc.topics.template import MessageTemplate
from wbc.topics.topic import MessageBlock, MessageTopic

Values = Callable[[TickBatch], Mapping[str, np.ndarray]]


class NumericTopic(MessageTopic):
    """A topic whose message is serialized once and then filled column by column for each batch.

    Ticks at which all its values are NaN have no message.

    Args:
        name: Name of the topic.
        message: Message with everything but the numbers; each `stamp` in it is filled in.
        values: Returns the values of a batch; see `MessageTemplate.fill`.
        period: Period of the messages, s; 0 publishes every tick.
    """

    def __init__(self, name: str, message: Message, values: Values, period: float = 0.0) -> None:
        super().__init__(name, type(message).type_name)
        self._template = MessageTemplate(message)
        self._values = values
        self._period = round(1e9 * period)
        self._due = 0

    def messages(self, batch: TickBatch) -> list[MessageBlock]:
        """Return the messages of a batch; see `MessageTopic.messages`."""
        ticks = self._ticks_due(batch)
        if not len(ticks):
            return []
        values = self._values(batch if len(ticks) == len(batch) else batch.select(ticks))
        numbers = [one.reshape(len(ticks), -1) for one in values.values()]
        known = ~np.isnan(np.concatenate(numbers, axis=1)).all(axis=1)
        if not known.any():
            return []
        if not known.all():
            ticks = ticks[known]
            values = {path: one[known] for path, one in values.items()}
        return [MessageBlock(ticks, self._template.fill(batch.stamps[ticks], values))]

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

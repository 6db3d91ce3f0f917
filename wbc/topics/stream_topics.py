"""The topics of the stream of ticks that a process reads."""

from __future__ import annotations

import numpy as np

from wbc.robot import Robot
from wbc.runtime.quantities import QUANTITIES
from wbc.runtime.record import contact_names
from wbc.runtime.schema import Schema, declared_columns
from wbc.topics.catalogue import commanded_wrench_topic, tick_topics
from wbc.topics.topic import MessageTopic


class StreamTopics:
    """The topics of a stream: those of its quantities, and one for each contact with a wrench.

    Before the first stream they are those of the library's own quantities, so that the time in
    which they are made is not taken from the run.

    Args:
        robot: Robot of the ticks.
        period: Period of the transforms, sole poses and ground truth, s; 0 publishes every tick.

    Attributes:
        schema: Schema of the stream.
        topics: Topics of the stream so far.
    """

    def __init__(self, robot: Robot, period: float = 0.02) -> None:
        self._robot, self._period = robot, period
        columns = declared_columns(robot, QUANTITIES)
        self._begin(Schema(tuple(column for column, _ in columns)))

    def _begin(self, schema: Schema) -> None:
        self.schema = schema
        self.topics: list[MessageTopic] = tick_topics(schema, self._robot, self._period)
        self._contacts: set[str] = set()
        self._seen: set[bytes] = set()  # names of contacts, as they lie in a record

    def attach(self, schema: Schema) -> bool:
        """Go over to a stream; return whether its quantities are other than those before."""
        if schema is self.schema:
            return False
        if schema == self.schema:
            self.schema = schema  # the same object is recognized at once
            return False
        self._begin(schema)
        return True

    def topics_of(self, records: np.ndarray) -> list[MessageTopic]:
        """Return all topics of which records, (n,), may have messages."""
        new = {row.tobytes() for row in records["contact_names"]} - self._seen
        if new:
            self._seen |= new
            contacts = contact_names(records) - self._contacts
            self._contacts |= contacts
            self.topics += [commanded_wrench_topic(contact) for contact in sorted(contacts)]
        return self.topics

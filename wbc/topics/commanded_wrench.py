"""Commanded contact wrenches: one topic per contact, added when the contact first appears."""

from __future__ import annotations

import numpy as np

from wbc.messages import message_type
from wbc.runtime.schema import CONTACTS
from wbc.topics.batch import TickBatch
from wbc.topics.message_topic import topic_name
from wbc.topics.numeric import NumericTopic


class CommandedWrench(NumericTopic):
    """The commanded wrench from the environment on the robot at one contact.

    Args:
        number: Number of the contact in the records.
        name: Name of the contact.
    """

    def __init__(self, number: int, name: str) -> None:
        self._number = number
        header = message_type("std_msgs/Header")(frame_id=name)
        super().__init__(
            topic_name("command", "wrench", name),
            message_type("geometry_msgs/WrenchStamped")(header=header),
            {"wrench": self._wrenches},
            self._commanded,
        )

    def _commanded(self, batch: TickBatch) -> np.ndarray:
        return np.asarray(self._at(batch).any(axis=1))

    def _at(self, batch: TickBatch) -> np.ndarray:
        """Return a mask of the entries that hold this contact's wrench, shape (n, CONTACTS)."""
        rows = batch.records["contacts"].reshape(-1, CONTACTS, 7)
        found: np.ndarray = rows[:, :, 0] == self._number
        return found

    def _wrenches(self, batch: TickBatch) -> np.ndarray:
        rows = batch.records["contacts"].reshape(-1, CONTACTS, 7)
        chosen: np.ndarray = rows[np.arange(len(rows)), self._at(batch).argmax(axis=1), 1:]
        return chosen

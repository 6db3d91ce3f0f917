"""Commanded contact wrenches: one topic per contact, added when the contact first appears."""

from __future__ import annotations

import numpy as np

from wbc.messages import message_type
from wbc.topics.batch import TickBatch
from wbc.topics.message_topic import topic_name
from wbc.topics.numeric import NumericTopic


class CommandedWrench(NumericTopic):
    """The commanded wrench from the environment on the robot at one contact.

    Args:
        name: Name of the contact.
    """

    def __init__(self, name: str) -> None:
        self._name = name.encode()
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
        found: np.ndarray = batch.records["contact_names"] == self._name
        return found

    def _wrenches(self, batch: TickBatch) -> np.ndarray:
        rows = np.arange(len(batch))
        chosen: np.ndarray = batch.records["contact_wrenches"][rows, self._at(batch).argmax(axis=1)]
        return chosen

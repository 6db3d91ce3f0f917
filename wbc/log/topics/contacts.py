"""Commanded contact wrenches: a topic per contact, as contacts turn up."""

from __future__ import annotations

import numpy as np

from wbc.log.layout import CONTACTS
from wbc.log.topics.block import Block
from wbc.log.topics.fixed import FixedTopic
from wbc.log.topics.topic import topic_name
from wbc.messages import message_type


class CommandedWrench(FixedTopic):
    """The wrench that the controller wants from the ground at one contact.

    Args:
        number: of the contact's name in the records.
        name: of the contact.
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

    def _commanded(self, block: Block) -> np.ndarray:
        return np.asarray(self._at(block).any(axis=1))

    def _at(self, block: Block) -> np.ndarray:
        """(n, CONTACTS) where this contact's wrench stands."""
        rows = block.records["contacts"].reshape(-1, CONTACTS, 7)
        found: np.ndarray = rows[:, :, 0] == self._number
        return found

    def _wrenches(self, block: Block) -> np.ndarray:
        rows = block.records["contacts"].reshape(-1, CONTACTS, 7)
        chosen: np.ndarray = rows[np.arange(len(rows)), self._at(block).argmax(axis=1), 1:]
        return chosen

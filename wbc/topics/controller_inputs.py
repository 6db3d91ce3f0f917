"""The topic of what the QP of each tick was made of."""

from __future__ import annotations

import numpy as np

from wbc.messages import message_type
from wbc.qp.inputs import packed_text, packed_values
from wbc.runtime.controller_inputs import NAME
from wbc.topics.batch import TickBatch
from wbc.topics.template import MessageTemplate
from wbc.topics.topic import MessageBlock, MessageTopic

_TYPE = "wbc_msgs/msg/ControllerInputs"
_MAX_TEMPLATES = 64


class ControllerInputsTopic(MessageTopic):
    """Publishes what the QP of each tick was made of; nothing for commands that come from none."""

    def __init__(self) -> None:
        super().__init__(NAME, _TYPE)
        self._templates: dict[tuple[bytes, int], MessageTemplate] = {}

    def messages(self, batch: TickBatch) -> list[MessageBlock]:
        """Return the messages of a batch; see `MessageTopic.messages`."""
        alike: dict[tuple[bytes, int], list[int]] = {}
        records = batch.records[NAME]
        for tick, words in enumerate(records):
            if not np.isnan(words[0]):
                alike.setdefault((packed_text(words), int(words[1])), []).append(tick)
        return [
            MessageBlock(
                np.array(ticks),
                self._template(*key).fill(
                    batch.stamps[ticks],
                    {"values": np.array([packed_values(records[tick]) for tick in ticks])}
                    if key[1]
                    else {},
                ),
            )
            for key, ticks in alike.items()
        ]

    def _template(self, text: bytes, count: int) -> MessageTemplate:
        """Return the template of messages with a structure and a number of values."""
        found = self._templates.get((text, count))
        if found is None:
            if len(self._templates) >= _MAX_TEMPLATES:
                self._templates.clear()
            structure = text.decode("utf-8", "replace")
            message = message_type(_TYPE)(structure=structure, values=np.zeros(count))
            found = self._templates[text, count] = MessageTemplate(message)
        return found

"""Events of a run on their way from the loop to another process."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import NamedTuple

from wbc.process import BlobQueue, BlobQueueFull, BlobTooLarge
from wbc.runtime.event import RunEvent

#: Messages that may wait, those of a flood of commands while the other process is busy for a
#: second; and the size of the largest one, bytes.
_SLOTS, _SIZE = 2048, 1 << 13
_LONGEST = 900  # characters of a text, of up to four bytes each


class NumberedEvent(NamedTuple):
    """An event with the number of the run in which it happened, from 1 on."""

    run: int
    event: RunEvent


class EventQueue:
    """A queue that never waits; an event for which there is no room is dropped.

    Args:
        descriptor: File descriptor of a queue made in another process; None makes a new queue.

    Attributes:
        dropped: Number of events that were dropped.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._queue = BlobQueue(_SLOTS, _SIZE, descriptor)
        self.dropped = 0

    @property
    def descriptor(self) -> int:
        """File descriptor to pass to the process that takes them."""
        return self._queue.descriptor

    def put(self, run: int, event: RunEvent) -> None:
        """Append an event; long values and reasons are cut."""
        short = replace(event, value=event.value[:_LONGEST], reason=event.reason[:_LONGEST])
        try:
            self._queue.put(pickle.dumps((run, short)))
        except (BlobQueueFull, BlobTooLarge):
            self.dropped += 1

    def take(self) -> list[NumberedEvent]:
        """Return the events since the last call."""
        found = []
        while (data := self._queue.get()) is not None:
            found.append(NumberedEvent(*pickle.loads(data)))
        return found

    def close(self) -> None:
        """Close the descriptor."""
        self._queue.close()

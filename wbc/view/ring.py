"""Snapshots on their way to the viewer's process, which takes the latest."""

from __future__ import annotations

import numpy as np

from wbc.process import RecordRing
from wbc.runtime.snapshot import Snapshot
from wbc.view.slot import Layout, Slot

SLOTS = 4


class Ring:
    """A few snapshots in shared memory, see `wbc.process.RecordRing`.

    Args:
        layout: the form of one.
        descriptor: of a ring made by another process; None makes a new one.
    """

    def __init__(self, layout: Layout, descriptor: int | None = None) -> None:
        self._records = RecordRing(layout.nbytes // 8, descriptor, SLOTS)
        self._slots = [Slot(layout, record.data.cast("B")) for record in self._records.records]
        self._copy = np.zeros(layout.nbytes // 8)
        self._taken = Slot(layout, self._copy.data.cast("B"))

    def write(self, snapshot: Snapshot) -> None:
        """Publish a snapshot. Only one process, and one thread of it, may do so."""
        self._records.begin()
        self._slots[self._records.index].write(snapshot)
        self._records.publish()

    def read(self) -> Snapshot | None:
        """The latest snapshot; None if there is none since the last call."""
        found = list(self._records.read())
        if not found:
            return None
        self._copy[:] = found[-1]
        return self._taken.read()

    @property
    def descriptor(self) -> int:
        """File descriptor to be inherited by the other process."""
        return self._records.descriptor

    def close(self) -> None:
        """Give up the descriptor. The memory goes with the last mapping."""
        self._records.close()

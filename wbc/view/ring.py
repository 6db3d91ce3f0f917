"""Shared memory with one writer that never waits and one reader that takes the latest."""

from __future__ import annotations

import numpy as np

from wbc.process import SharedMemory
from wbc.snapshot import Snapshot
from wbc.view.slot import Layout, Slot

SLOTS = 4
_LINE = 64  # bytes: stamps sit on cache lines of their own


class Ring:
    """A few slots in shared memory, written in turn.

    A slot is stamped before and after it is written; a reader that finds the two
    stamps unequal, or changed after copying, was overtaken and tries again. It
    would have to be slower than `SLOTS - 1` writes for that to happen.

    Args:
        layout: the form of one slot.
        descriptor: of a file made by another `Ring`; None makes a new one.
    """

    def __init__(self, layout: Layout, descriptor: int | None = None) -> None:
        stride = -(-layout.nbytes // _LINE) * _LINE + 2 * _LINE
        size = _LINE + SLOTS * stride
        self._memory = SharedMemory(size, descriptor)
        view = self._memory.view
        self._published = np.frombuffer(view, dtype=np.uint64, count=1)
        self._before, self._after, self._slots = [], [], []
        for i in range(SLOTS):
            start = _LINE + i * stride
            stop = start + stride
            self._before.append(np.frombuffer(view[start:], dtype=np.uint64, count=1))
            self._after.append(np.frombuffer(view[stop - _LINE :], dtype=np.uint64, count=1))
            self._slots.append(Slot(layout, view[start + _LINE : stop - _LINE]))
        self._sequence = int(self._published[0])
        self._seen = 0

    def write(self, snapshot: Snapshot) -> None:
        """Publish a snapshot. Only one process, and one thread of it, may do so."""
        sequence = self._sequence + 1
        i = sequence % SLOTS
        self._before[i][0] = sequence
        self._slots[i].write(snapshot)
        self._after[i][0] = sequence
        self._published[0] = self._sequence = sequence

    def read(self) -> Snapshot | None:
        """The latest snapshot; None if there is none since the last call."""
        for _ in range(SLOTS):
            sequence = int(self._published[0])
            if sequence == self._seen:
                return None
            i = sequence % SLOTS
            after = int(self._after[i][0])
            snapshot = self._slots[i].read()
            if after == sequence == int(self._before[i][0]):
                self._seen = sequence
                return snapshot
        return None

    @property
    def descriptor(self) -> int:
        """File descriptor to be inherited by the other process."""
        return self._memory.descriptor

    def close(self) -> None:
        """Give up the descriptor. The memory goes with the last mapping."""
        self._memory.close()

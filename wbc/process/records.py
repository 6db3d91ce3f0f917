"""Records of numbers on their way to another process; the writer never waits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wbc.process.memory import SharedMemory

SLOTS = 256
_LINE = 8  # words: what the writer announces sits on a cache line of its own


class RecordRing:
    """Records in shared memory that are written in turn, the oldest overwritten.

    A record is numbered before and after it is written; a reader that finds the numbers
    unequal, or not those that it expects, was overtaken and goes on with newer records.

    Args:
        size: numbers in a record.
        descriptor: of a ring made by another process; None makes a new one.
    """

    def __init__(self, size: int, descriptor: int | None = None) -> None:
        self._stride = size + 2  # a number before it, and one after it
        words = _LINE + SLOTS * self._stride
        self._memory = SharedMemory(8 * words, descriptor)
        view = self._memory.view
        self._words = view.cast("Q")
        table = np.frombuffer(view, np.float64, SLOTS * self._stride, 8 * _LINE)
        self._records = table.reshape(SLOTS, self._stride)[:, 1:-1]
        if descriptor is None:
            self._records[:] = 0.0  # the kernel gives memory at its first use: not in a tick
        self._seen = self._sequence = int(self._words[0])

    @property
    def descriptor(self) -> int:
        """File descriptor to be inherited by the other process."""
        return self._memory.descriptor

    def begin(self) -> np.ndarray:
        """The record to be written next."""
        self._sequence += 1
        i = self._sequence % SLOTS
        self._words[_LINE + i * self._stride] = self._sequence
        record: np.ndarray = self._records[i]
        return record

    def publish(self) -> None:
        """It is written."""
        i = self._sequence % SLOTS
        self._words[_LINE + (i + 1) * self._stride - 1] = self._sequence
        self._words[0] = self._sequence

    def read(self) -> Iterator[np.ndarray]:
        """Copies of the records since the last call, in order; those overwritten are left out."""
        published = int(self._words[0])
        self._seen = max(self._seen, published - SLOTS // 2)
        while self._seen < published:
            self._seen += 1
            i = self._seen % SLOTS
            copy = self._records[i].copy()
            first = self._words[_LINE + i * self._stride]
            last = self._words[_LINE + (i + 1) * self._stride - 1]
            if first == last == self._seen:
                yield copy

    def close(self) -> None:
        """Give up the descriptor. The memory goes with the last mapping."""
        self._memory.close()

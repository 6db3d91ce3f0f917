"""Records of numbers on their way to another process; the writer never waits."""

from __future__ import annotations

import struct
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
        slots: number of records; half of them may wait to be read.

    Attributes:
        records: (slots, size) all of them.
    """

    def __init__(self, size: int, descriptor: int | None = None, slots: int = SLOTS) -> None:
        self._stride, self._slots = size + 2, slots  # a number before it, and one after it
        words = _LINE + slots * self._stride
        self._memory = SharedMemory(8 * words, descriptor)
        view = self._memory.view
        self._view, self._words = view, view.cast("Q")
        table = np.frombuffer(view, np.float64, slots * self._stride, 8 * _LINE)
        self.records = table.reshape(slots, self._stride)[:, 1:-1]
        if descriptor is None:
            self.records[:] = 0.0  # the kernel gives memory at its first use: not in a tick
        self._seen, self._sequence = 0, int(self._words[0])

    @property
    def descriptor(self) -> int:
        """File descriptor to be inherited by the other process."""
        return self._memory.descriptor

    @property
    def index(self) -> int:
        """Of the record that is being written."""
        return self._sequence % self._slots

    def begin(self) -> np.ndarray:
        """The record to be written next."""
        self._sequence += 1
        i = self.index
        self._words[_LINE + i * self._stride] = self._sequence
        record: np.ndarray = self.records[i]
        return record

    def pack(self, form: struct.Struct, *numbers: float) -> None:
        """Write the record's first numbers, in a third of the time that numpy takes.

        Args:
            form: so many doubles.
            numbers: as many.
        """
        first = _LINE + self.index * self._stride + 1
        form.pack_into(self._view, 8 * first, *numbers)

    def publish(self) -> None:
        """It is written."""
        i = self.index
        self._words[_LINE + (i + 1) * self._stride - 1] = self._sequence
        self._words[0] = self._sequence

    def read(self) -> Iterator[np.ndarray]:
        """Copies of the records since the last call, in order; those overwritten are left out."""
        published = int(self._words[0])
        self._seen = max(self._seen, published - self._slots // 2)
        while self._seen < published:
            self._seen += 1
            i = self._seen % self._slots
            copy = self.records[i].copy()
            first = self._words[_LINE + i * self._stride]
            last = self._words[_LINE + (i + 1) * self._stride - 1]
            if first == last == self._seen:
                yield copy

    def close(self) -> None:
        """Give up the descriptor. The memory goes with the last mapping."""
        self._memory.close()

"""Records of ticks on their way to the log's process: a ring in shared memory.

One process writes and never waits: what finds no room is dropped, and counted. Another
process takes, as slowly as it likes. Neither locks: the one moves only the head, the other
only the tail.
"""

from __future__ import annotations

import struct

import numpy as np

from wbc.log.layout import HEAD, TEXT, Layout
from wbc.process import SharedMemory

NAMES = 64
_NAME = 64  # bytes
_LINE = 8  # words: the counters sit on cache lines of their own
_HEAD, _TAIL, _DROPPED, _STOPPED, _NAMED = (i * _LINE for i in range(5))
_COUNTERS = 5 * _LINE * 8
_HEAD_FORM = struct.Struct(f"={len(HEAD)}d")


class TickRing:
    """Records in shared memory, in the order of time.

    Args:
        layout: of one record.
        capacity: number of records that it holds.
        descriptor: of a ring made by another process; None makes a new one.

    Attributes:
        flat: (capacity, size) the records as numbers.
    """

    def __init__(self, layout: Layout, capacity: int, descriptor: int | None = None) -> None:
        self.capacity = capacity
        dtype = layout.dtype
        start = _COUNTERS + TEXT + NAMES * _NAME
        self._memory = SharedMemory(start + capacity * dtype.itemsize, descriptor)
        view = self._memory.view
        # Plain integers: a memoryview reads one in a third of the time that numpy takes.
        self._counters = view[:_COUNTERS].cast("Q")
        self._reason = view[_COUNTERS : _COUNTERS + TEXT]
        self._names = view[_COUNTERS + TEXT : start]
        self._bytes, self._stride = view[start:], dtype.itemsize
        self._records = np.frombuffer(self._bytes, dtype, capacity)
        self.flat = self._records.view(np.float64).reshape(capacity, -1)
        self._known: list[str] = []
        if descriptor is None:
            self.flat[:] = 0.0  # the kernel gives memory at its first use: not in a tick

    @property
    def descriptor(self) -> int:
        """File descriptor to be inherited by the other process."""
        return self._memory.descriptor

    def claim(self) -> int:
        """Index of the record to be written next; -1 when there is no room, which counts."""
        counters = self._counters
        head = counters[_HEAD]
        if head - counters[_TAIL] >= self.capacity:
            counters[_DROPPED] += 1
            return -1
        return int(head % self.capacity)

    def write_head(self, index: int, *numbers: float) -> None:
        """Write the numbers of `HEAD` into a record."""
        _HEAD_FORM.pack_into(self._bytes, index * self._stride, *numbers)

    def publish(self) -> None:
        """The record that was claimed is written."""
        self._counters[_HEAD] += 1

    def take(self, most: int) -> np.ndarray:
        """Records that are there and were not released yet, at most so many, not copied."""
        tail = self._counters[_TAIL]
        start = int(tail % self.capacity)
        count = min(int(self._counters[_HEAD] - tail), most, self.capacity - start)
        return self._records[start : start + count]

    def release(self, count: int) -> None:
        """So many of the records that were taken may be overwritten."""
        self._counters[_TAIL] += count

    @property
    def written(self) -> int:
        """Records published so far."""
        return int(self._counters[_HEAD])

    @property
    def dropped(self) -> int:
        """Records that found no room so far."""
        return int(self._counters[_DROPPED])

    def stop(self, reason: str) -> None:
        """Nobody takes any more, and why; told to the writing process."""
        text = reason.encode("utf-8", "replace")[:TEXT]
        self._reason[: len(text)] = text
        self._counters[_STOPPED] = 1 + len(text)

    @property
    def stopped(self) -> bool:
        """Whether nobody takes any more."""
        return self._counters[_STOPPED] != 0

    @property
    def reason(self) -> str:
        """Why nobody takes any more; empty while somebody does."""
        size = max(int(self._counters[_STOPPED]) - 1, 0)
        return bytes(self._reason[:size]).decode("utf-8", "ignore")

    def name(self, name: str) -> int:
        """Number of a contact's name, by which records mention it; -1 when there are too many."""
        number = int(self._counters[_NAMED])
        if number >= NAMES:
            return -1
        text = name.encode("utf-8", "replace")[: _NAME - 1]
        self._names[number * _NAME : number * _NAME + len(text) + 1] = text + b"\0"
        self._counters[_NAMED] = number + 1
        return number

    @property
    def names(self) -> list[str]:
        """Names of contacts by their numbers."""
        for number in range(len(self._known), int(self._counters[_NAMED])):
            text = bytes(self._names[number * _NAME : (number + 1) * _NAME])
            self._known.append(text.partition(b"\0")[0].decode("utf-8", "ignore"))
        return self._known

    def close(self) -> None:
        """Give up the descriptor. The memory goes with the last mapping."""
        self._memory.close()

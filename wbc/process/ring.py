"""A ring of fixed-size records in shared memory: one writer, any number of readers.

The writer never waits; it overwrites the oldest record. A reader copies records out and then
checks whether the writer has meanwhile begun to overwrite them: those are dropped and counted.
"""

from __future__ import annotations

import numpy as np

from wbc.process.memory import SharedMemory

_LINE = 8  # 64-bit words: each counter has a cache line of its own
_BEGUN, _PUBLISHED = 0, _LINE
_COUNTERS = 2 * _LINE


class SharedRing:
    """Records of 64-bit words, numbered from 0; record k lies in row k modulo `capacity`.

    Args:
        size: 64-bit words in a record.
        capacity: number of records.
        descriptor: file descriptor of a ring made by another process; None makes a new one.

    Attributes:
        rows: (capacity, size) float64, all records.
    """

    def __init__(self, size: int, capacity: int, descriptor: int | None = None) -> None:
        self.capacity = capacity
        start = 8 * _COUNTERS
        self._memory = SharedMemory(start + 8 * size * capacity, descriptor)
        view = self._memory.view
        # A memoryview reads one integer in a third of the time that numpy takes.
        self._counters = view[:start].cast("Q")
        self.rows = np.frombuffer(view, np.float64, size * capacity, start).reshape(capacity, size)
        if descriptor is None:
            self.rows[:] = 0.0  # the kernel maps memory at its first use: not in a tick

    @property
    def descriptor(self) -> int:
        """File descriptor for the other processes."""
        return self._memory.descriptor

    @property
    def published(self) -> int:
        """Number of records published so far."""
        return int(self._counters[_PUBLISHED])

    @property
    def begun(self) -> int:
        """Number of records begun so far."""
        return int(self._counters[_BEGUN])

    def begin(self) -> int:
        """Begin the next record and return its row. Only one process, and one thread, may."""
        number = self._counters[_PUBLISHED]
        self._counters[_BEGUN] = number + 1
        return int(number % self.capacity)

    def publish(self) -> None:
        """Make the record that was begun visible to the readers."""
        self._counters[_PUBLISHED] = self._counters[_BEGUN]

    def close(self) -> None:
        """Close the descriptor. The kernel frees the memory with its last user."""
        self._memory.close()


class RingReader:
    """One reader's place in a ring. It starts at the records that are published after it.

    Args:
        ring: the ring.
        first: number of the first record to read; None: the next to be published.

    Attributes:
        lost: records that the writer overwrote before this reader took them.
    """

    def __init__(self, ring: SharedRing, first: int | None = None) -> None:
        self._ring = ring
        self._next = ring.published if first is None else first
        self.lost = 0

    @property
    def waiting(self) -> int:
        """Number of records that `take` could return."""
        return min(self._ring.published - self._next, self._ring.capacity)

    def take(self, most: int) -> np.ndarray:
        """Return copies of the next records, oldest first.

        Args:
            most: number of records at most.

        Returns:
            (n, size) the records; n is 0 when there is none yet.
        """
        ring = self._ring
        self._skip_to(ring.begun - ring.capacity)
        row = self._next % ring.capacity
        count = min(ring.published - self._next, most, ring.capacity - row)
        rows = ring.rows[row : row + count].copy()
        first = self._next
        self._next += count
        overwritten = min(max(ring.begun - ring.capacity - first, 0), count)
        self.lost += overwritten
        return rows[overwritten:]

    def latest(self) -> np.ndarray | None:
        """Return a copy of the newest record, (size,); None if there is none since the last call.

        The records before it are skipped and do not count as lost.
        """
        ring = self._ring
        while ring.published > self._next:
            number = ring.published - 1
            row: np.ndarray = ring.rows[number % ring.capacity].copy()
            if number >= ring.begun - ring.capacity:
                self._next = number + 1
                return row
        return None

    def _skip_to(self, number: int) -> None:
        if number > self._next:
            self.lost += number - self._next
            self._next = number

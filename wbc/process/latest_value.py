"""The latest value of a few numbers, for another process to read at any time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wbc.process.memory import SharedMemory


class LatestValue:
    """A few float64 in shared memory, guarded by a sequence lock; neither side ever waits.

    There is one writer; each reader has an instance of its own.

    Args:
        size: number of values.
        descriptor: file descriptor of memory made in another process; None makes new memory.
    """

    def __init__(self, size: int, descriptor: int | None = None) -> None:
        self._memory = SharedMemory(8 * (1 + size), descriptor)
        view = self._memory.view
        self._sequence = view.cast("Q")
        self._values = np.frombuffer(view, np.float64, size, 8)
        self._seen = 0
        self._latest = np.zeros(size)

    @property
    def descriptor(self) -> int:
        """File descriptor that the other process inherits."""
        return self._memory.descriptor

    def write(self, values: Sequence[float] | np.ndarray) -> None:
        """Replace the values."""
        sequence = self._sequence[0]
        self._sequence[0] = sequence + 1  # odd: being written
        self._values[:] = values
        self._sequence[0] = sequence + 2

    def read(self) -> np.ndarray:
        """Return the latest values; while they are being written, those of the last call."""
        sequence = self._sequence[0]
        if sequence == self._seen or sequence % 2:
            return self._latest
        values = self._values.copy()
        if self._sequence[0] == sequence:
            self._seen, self._latest = sequence, values
        return self._latest

    def close(self) -> None:
        """Close the descriptor. The memory is freed with its last mapping."""
        self._memory.close()

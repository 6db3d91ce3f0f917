"""Messages of bytes on their way to another process, in order; neither side ever waits."""

from __future__ import annotations

from wbc.errors import WbcError
from wbc.process.memory import SharedMemory

_LINE = 8  # words: each side's counter is on a cache line of its own
_WRITTEN, _READ = 0, _LINE


class BlobQueueFull(WbcError):
    """The queue has no free slot: the other process does not read, or not fast enough."""


class BlobTooLarge(WbcError):
    """A message is larger than a slot."""


class BlobQueue:
    """A first-in, first-out queue of byte strings in shared memory.

    There is one writer and one reader, each a single thread. A slot is free again as soon as its
    message has been read.

    Args:
        slots: number of messages that may wait.
        slot_size: size of the largest message, bytes.
        descriptor: file descriptor of a queue made in another process; None makes a new queue.
    """

    def __init__(self, slots: int, slot_size: int, descriptor: int | None = None) -> None:
        self._slots, self._slot_size = slots, slot_size
        counters = 8 * 2 * _LINE
        self._start = counters + 8 * slots
        self._memory = SharedMemory(self._start + slots * slot_size, descriptor)
        self._words = self._memory.view[: self._start].cast("Q")

    @property
    def descriptor(self) -> int:
        """File descriptor that the other process inherits."""
        return self._memory.descriptor

    def put(self, message: bytes) -> None:
        """Append a message.

        Raises:
            BlobTooLarge: the message is larger than a slot.
            BlobQueueFull: the reader has not taken the earlier messages yet.
        """
        size = len(message)
        if size > self._slot_size:
            raise BlobTooLarge(f"a message of {size} bytes; at most {self._slot_size} are taken")
        written = self._words[_WRITTEN]
        if written - self._words[_READ] >= self._slots:
            raise BlobQueueFull(f"{self._slots} messages wait to be read")
        slot = written % self._slots
        start = self._start + slot * self._slot_size
        self._memory.view[start : start + size] = message
        self._words[2 * _LINE + slot] = size
        self._words[_WRITTEN] = written + 1  # publishes it

    def get(self) -> bytes | None:
        """Return the next message; None if there is none."""
        read = self._words[_READ]
        if read == self._words[_WRITTEN]:
            return None
        slot = read % self._slots
        start = self._start + slot * self._slot_size
        message = bytes(self._memory.view[start : start + self._words[2 * _LINE + slot]])
        self._words[_READ] = read + 1  # frees the slot
        return message

    def close(self) -> None:
        """Close the descriptor. The memory is freed with its last mapping."""
        self._memory.close()

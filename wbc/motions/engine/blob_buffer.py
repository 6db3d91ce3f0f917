"""A buffer in shared memory that carries packed motions from another process to the loop."""

from __future__ import annotations

from wbc.errors import MotionError
from wbc.process import SharedMemory

SLOTS = 32
SLOT_SIZE = 1 << 19  # bytes per motion: some 2 ms to unpack


class BlobBuffer:
    """Slots in shared memory; slot and size of a blob are sent by other means.

    Slots are used in turn. A slot is overwritten after all others, by when the loop has read it,
    because there are never more open requests than slots.

    Args:
        descriptor: file descriptor of a buffer made by another process; None makes a new one.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._memory = SharedMemory(SLOTS * SLOT_SIZE, descriptor)
        self._next = 0

    @property
    def descriptor(self) -> int:
        """File descriptor, for the other process to inherit."""
        return self._memory.descriptor

    def write(self, data: bytes) -> int:
        """Write a blob and return its slot.

        Raises:
            MotionError: the blob is too large.
        """
        if len(data) > SLOT_SIZE:
            raise MotionError(
                f"the plan of this motion takes {len(data)} bytes; at most {SLOT_SIZE} can be "
                "unpacked within a tick: make the motion shorter"
            )
        slot = self._next
        self._next = (slot + 1) % SLOTS
        self._memory.view[slot * SLOT_SIZE : slot * SLOT_SIZE + len(data)] = data
        return slot

    def read(self, slot: int, size: int) -> bytes:
        """Return a copy of the blob in a slot."""
        return bytes(self._memory.view[slot * SLOT_SIZE : slot * SLOT_SIZE + size])

    def close(self) -> None:
        """Close the descriptor; the memory is freed with the last mapping."""
        self._memory.close()

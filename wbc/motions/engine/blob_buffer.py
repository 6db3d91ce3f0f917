"""Where another process puts motions, packed with their plans, for the loop to take."""

from __future__ import annotations

from wbc.errors import MotionError
from wbc.process import SharedMemory

SLOTS = 32
ROOM = 1 << 19  # bytes per motion: some 2 ms to unpack


class BlobBuffer:
    """Slots in shared memory; who is told the slot and the size takes what lies there.

    A slot is filled anew after all others: by then the loop has taken what lay there, since it
    may owe no more requests than there are slots.

    Args:
        descriptor: of a shelf made by another process; None makes a new one.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._memory = SharedMemory(SLOTS * ROOM, descriptor)
        self._next = 0

    @property
    def descriptor(self) -> int:
        """File descriptor to be inherited by the other process."""
        return self._memory.descriptor

    def put(self, data: bytes) -> int:
        """Lay something down; returns the slot.

        Raises:
            MotionError: it is too big.
        """
        if len(data) > ROOM:
            raise MotionError(
                f"the plan of this motion takes {len(data)} bytes; at most {ROOM} are taken within "
                "a tick: make it shorter"
            )
        slot = self._next
        self._next = (slot + 1) % SLOTS
        self._memory.view[slot * ROOM : slot * ROOM + len(data)] = data
        return slot

    def take(self, slot: int, size: int) -> bytes:
        """A copy of what lies in a slot."""
        return bytes(self._memory.view[slot * ROOM : slot * ROOM + size])

    def close(self) -> None:
        """Give up the descriptor. The memory goes with the last mapping."""
        self._memory.close()

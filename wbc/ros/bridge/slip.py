"""A line of text on its way from the loop to the node, beside the numbers of the ticks."""

from __future__ import annotations

import struct

from wbc.process import SharedMemory

_LONGEST = 1000  # bytes
_HEAD = struct.Struct("=2q")


class Slip:
    """The last line, and what it is about; written before the tick that tells to look.

    Args:
        descriptor: of a slip made by another process; None makes a new one.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._memory = SharedMemory(_HEAD.size + _LONGEST, descriptor)

    @property
    def descriptor(self) -> int:
        """File descriptor to be inherited by the other process."""
        return self._memory.descriptor

    def write(self, about: int, text: str) -> None:
        """Put a line there instead of the one before."""
        data = text.encode("utf-8")[:_LONGEST]
        self._memory.view[_HEAD.size : _HEAD.size + len(data)] = data
        _HEAD.pack_into(self._memory.view, 0, about, len(data))

    def read(self, about: int) -> str:
        """The line about that; empty if there is none."""
        told, size = _HEAD.unpack_from(self._memory.view)
        if told != about:
            return ""
        data = bytes(self._memory.view[_HEAD.size : _HEAD.size + size])
        return data.decode("utf-8", "ignore")

    def close(self) -> None:
        """Give up the descriptor. The memory goes with the last mapping."""
        self._memory.close()

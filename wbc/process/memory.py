"""Memory that two processes share, without a name.

It is an unlinked file of the memory file system, handed to the other process as an
inherited descriptor. The kernel frees it with its last user, so that not even two killed
processes leave anything behind.
"""

from __future__ import annotations

import mmap
import os
import tempfile


class SharedMemory:
    """Some bytes that a child process sees too.

    Args:
        size: bytes.
        descriptor: of memory made in another process; None makes new memory, all zero.

    Attributes:
        descriptor: file descriptor to be inherited by the other process.
        view: the bytes.
    """

    def __init__(self, size: int, descriptor: int | None = None) -> None:
        self.descriptor = _new_file(size) if descriptor is None else descriptor
        self.view = memoryview(mmap.mmap(self.descriptor, size))

    def close(self) -> None:
        """Give up the descriptor. The memory goes with the last mapping."""
        if self.descriptor >= 0:
            os.close(self.descriptor)
            self.descriptor = -1


def _new_file(size: int) -> int:
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("wbc")
    else:  # macOS
        with tempfile.TemporaryFile(prefix="wbc") as file:
            descriptor = os.dup(file.fileno())
    os.truncate(descriptor, size)
    return descriptor

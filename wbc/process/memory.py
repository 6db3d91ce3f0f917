"""Anonymous memory that two processes share.

It is an unlinked file of the memory file system, which the child process inherits as a descriptor.
The kernel frees it together with its last user, so that even two killed processes leave nothing
behind.
"""

from __future__ import annotations

import mmap
import os
import tempfile


class SharedMemory:
    """A block of memory that a child process sees too.

    Args:
        size: bytes.
        descriptor: file descriptor of memory made in another process; None makes new memory, all
            zero.

    Attributes:
        descriptor: file descriptor that the other process inherits.
        view: the bytes.
    """

    def __init__(self, size: int, descriptor: int | None = None) -> None:
        self.descriptor = _new_file(size) if descriptor is None else descriptor
        self.view = memoryview(mmap.mmap(self.descriptor, size))

    def close(self) -> None:
        """Close the descriptor. The memory is freed with its last mapping."""
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

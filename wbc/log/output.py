"""A file that is written in whole blocks, and truncated to the last whole one after a failure."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path


class Output:
    """A buffered file with commits. Nothing reaches the file before `commit`.

    Args:
        path: Path of the file. An existing file is emptied.

    Raises:
        OSError: The file cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_CLOEXEC", 0)
        self._file = os.open(path, flags, 0o644)
        self._buffer = bytearray()
        self._whole = 0  # bytes committed so far

    def write(self, data: bytes) -> int:
        """Append bytes to the buffer; return their number."""
        self._buffer += data
        return len(data)

    def tell(self) -> int:
        """Return the number of bytes appended so far."""
        return self._whole + len(self._buffer)

    def flush(self) -> None:
        """Do nothing; only `commit` writes to the file."""

    def commit(self) -> None:
        """Write the buffer to the file and synchronise the file with the disk.

        Raises:
            OSError: Writing failed; the file then ends with the previous commit.
        """
        left = memoryview(self._buffer)
        try:
            while left:
                left = left[os.write(self._file, left) :]
            getattr(os, "fdatasync", os.fsync)(self._file)
        except OSError:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self._whole)
            raise
        finally:
            left.release()
        self._whole += len(self._buffer)
        self._buffer.clear()

    def close(self) -> None:
        """Close the file and discard what was not committed."""
        os.close(self._file)

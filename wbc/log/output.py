"""A file that is written in whole pieces, and cut back to the last whole one when it fails."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path


class Output:
    """What MCAP's writer writes to. Nothing reaches the file before `commit`.

    Args:
        path: of the file; one that is there is emptied.

    Raises:
        OSError: it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_CLOEXEC", 0)
        self._file = os.open(path, flags, 0o644)
        self._buffer = bytearray()
        self._whole = 0  # bytes of the file that belong to whole pieces

    def write(self, data: bytes) -> int:
        """Take bytes."""
        self._buffer += data
        return len(data)

    def tell(self) -> int:
        """Bytes taken so far."""
        return self._whole + len(self._buffer)

    def flush(self) -> None:
        """Nothing: MCAP's writer flushes in the middle of a piece."""

    def commit(self) -> None:
        """What was taken is a whole piece: bring it into the file, and the file to the disk.

        Raises:
            OSError: it did not go; the file then ends with the piece before.
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
        """Close the file. What was not committed is lost."""
        os.close(self._file)

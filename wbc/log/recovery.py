"""Completes a log that was interrupted: everything up to its last whole chunk, and an end.

A log that just stops has lost nothing of what its chunks hold, but most readers want the
summary at its end. It is made of what the chunks say.
"""

from __future__ import annotations

import os
from pathlib import Path

from wbc.log.errors import LogError
from wbc.log.format.index_scan import IndexScan


def repair(path: Path) -> float:
    """Complete a log in place; a log that is whole stays as it is.

    What follows the last whole chunk is cut off. If the disk has no room for the summary,
    chunks at the end make room for it.

    Returns:
        Time of its last message, s.

    Raises:
        LogError: the file is no MCAP file, or cannot be written.
    """
    try:
        with path.open("rb") as file:
            scan = IndexScan(file)
        contents, size = scan.contents, scan.size
        while not scan.complete:
            try:
                _replace_end(path, size, contents.ending(size))
                break
            except OSError:
                if not contents.chunks:
                    raise
                size = contents.drop_last_chunk()
        return 1e-9 * contents.end
    except OSError as error:
        raise LogError(f"cannot repair {path}: {error.strerror}") from error


def _replace_end(path: Path, start: int, end: bytes) -> None:
    file = os.open(path, os.O_WRONLY)
    try:
        os.ftruncate(file, start)
        os.lseek(file, start, os.SEEK_SET)
        left = memoryview(end)
        while left:
            left = left[os.write(file, left) :]
        os.fsync(file)
    finally:
        os.close(file)

"""Completes an interrupted log: keeps the whole chunks and appends a summary.

A truncated log still holds all of its whole chunks, but most readers need the summary section
at the end of the file. It is rebuilt from the chunks.
"""

from __future__ import annotations

import os
from pathlib import Path

from wbc.log.errors import LogError
from wbc.log.format.index_scan import IndexScan


def repair(path: Path) -> float:
    """Complete a log in place; a complete log stays unchanged.

    Everything after the last whole chunk is removed. If the disk has no room for the summary,
    the last chunks are removed to make room.

    Returns:
        Time of the last message, s.

    Raises:
        LogError: The file is not an MCAP file, or cannot be written.
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

"""Completes an interrupted log: keeps the whole chunks and appends a summary.

A truncated log still holds all of its whole chunks, but most readers need the summary section
at the end of the file. It is made from the chunks, in place: that takes no room for a copy.
"""

from __future__ import annotations

import os
from pathlib import Path

from wbc.log.errors import LogError, require_packages


def repair(path: Path) -> float:
    """Complete a log in place; a complete log stays unchanged.

    Everything after the last whole chunk is removed. If the disk has no room for the summary,
    the last chunks are removed to make room.

    Returns:
        Time of the last message, s.

    Raises:
        LogError: The file is not an MCAP file, or cannot be written.
        MissingExtra: `mcap` or `rosbags` is not installed.
    """
    require_packages()
    from wbc.log.data_section import DataSection

    try:
        with path.open("rb") as file:
            section = DataSection(file)
        while not section.complete:
            try:
                _replace_end(path, section.size, section.summary())
                break
            except OSError:
                if not section.drop_last_chunk():
                    raise
        return section.end_time
    except OSError as error:
        raise LogError(f"cannot repair {path}: {error.strerror}") from error


def _replace_end(path: Path, start: int, end: bytes) -> None:
    """Truncate a file at an offset, and append bytes."""
    with path.open("r+b") as file:
        file.truncate(start)
        file.seek(start)
        file.write(end)
        file.flush()
        os.fsync(file.fileno())

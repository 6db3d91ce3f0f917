"""Completes interrupted logs, and copies what is whole of damaged ones."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from wbc.atomic_file import replacing
from wbc.log.errors import LogError, require_packages

if TYPE_CHECKING:
    from wbc.log.data_section import Gap


@dataclass(frozen=True)
class RepairedLog:
    """The outcome of a repair.

    Attributes:
        path: Path of the repaired log.
        end_time: Time of its last message, s.
        finished: Whether the original had its end.
        gaps: What is missing because it was damaged.
    """

    path: Path
    end_time: float
    finished: bool
    gaps: tuple[Gap, ...]


def repair(path: Path, target: Path) -> RepairedLog:
    """Write a complete copy of a log without what is damaged in it. The log stays unchanged.

    A chunk whose checksum is wrong is left out, and what follows it is kept. The indices of the
    messages are written anew.

    Args:
        path: Path of the log.
        target: Path of the copy, which must be another file. An existing file is replaced when the
            copy is complete.

    Raises:
        LogError: The file is not an MCAP file, `target` is the log itself, or a file cannot be
            read or written.
        MissingExtra: `mcap` or `rosbags` is not installed.
    """
    require_packages()
    from wbc.log.section_copy import copy_section

    try:
        if target.exists() and path.samefile(target):
            raise LogError(f"the repaired log must be another file than {path}")
        with path.open("rb") as source, replacing(target) as partial, partial.open("wb") as copy:
            section, summary = copy_section(source, copy)
            copy.flush()
            os.fsync(copy.fileno())
    except OSError as error:
        raise LogError(f"cannot repair {path} as {target}: {error.strerror}") from error
    return RepairedLog(target, summary.end_time, section.finished, tuple(section.gaps))


def complete(path: Path) -> float:
    """Append the end to a log whose writer was killed; other logs stay unchanged.

    A part of a chunk at the end is removed: that takes no room for a copy. If the disk has no room
    for the summary, the last chunks are removed to make room. A damaged log stays as it is.

    Returns:
        Time of the last message, s.

    Raises:
        LogError: The file is not an MCAP file, or cannot be written.
        MissingExtra: `mcap` or `rosbags` is not installed.
    """
    require_packages()
    from wbc.log.section_copy import index_section

    try:
        with path.open("rb") as file:
            section, summary, size = index_section(file)
        while not (section.finished or section.gaps):
            try:
                _replace_end(path, size, summary.encode(size))
                break
            except OSError:
                if summary.last_chunk is None:
                    raise
                size = summary.drop_last_chunk()
        return summary.end_time
    except OSError as error:
        raise LogError(f"cannot complete {path}: {error.strerror}") from error


def _replace_end(path: Path, start: int, end: bytes) -> None:
    """Truncate a file at an offset, and append bytes."""
    with path.open("r+b") as file:
        file.truncate(start)
        file.seek(start)
        file.write(end)
        file.flush()
        os.fsync(file.fileno())

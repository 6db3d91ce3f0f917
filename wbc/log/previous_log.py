"""The log that a new one of the same name replaces, kept until the new one is complete."""

from __future__ import annotations

import contextlib
from pathlib import Path


class PreviousLog:
    """A log set aside as `NAME.previous.mcap` while another is written in its place.

    Moving takes no room on the disk, so that a disk that becomes full costs the new log only. A
    device or a pipe is not moved. A file that was set aside before and never removed, because
    its successor was not completed, is kept: then the path's own file is overwritten.

    Args:
        path: path of the log.

    Attributes:
        kept: path of the file set aside; None if there is none.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.kept: Path | None = None
        aside = path.with_name(f"{path.stem}.previous{path.suffix}")
        if path.is_file() and not aside.exists():
            with contextlib.suppress(OSError):  # opening the new log tells what is wrong
                path.rename(aside)
                self.kept = aside

    def restore(self) -> None:
        """Give the file its name again, because no other was written."""
        if self.kept is not None:
            with contextlib.suppress(OSError):
                self.kept.rename(self._path)
            self.kept = None

    def remove(self) -> None:
        """Delete the file, because its successor is complete."""
        if self.kept is not None:
            self.kept.unlink(missing_ok=True)
            self.kept = None

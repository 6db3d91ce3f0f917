"""Files that are replaced only by complete ones."""

from __future__ import annotations

import contextlib
import stat
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a path beside a file, to write to; it becomes the file when the block succeeds.

    If the block fails, for instance on a full disk, the file stays what it was. The folder is
    created. A device or a pipe is written to directly.

    Args:
        path: Path of the file.

    Raises:
        OSError: The folder cannot be created, or the file cannot be replaced.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    path = path.resolve()  # a link stays one
    if path.exists() and not stat.S_ISREG(path.stat().st_mode):
        yield path
        return
    partial = path.with_name(f".{path.name}.partial")
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)

"""Digests of files and texts, by which results are known to belong to what computed them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path


def text_digest(text: str) -> str:
    """Return a digest of a text."""
    return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()


def path_digest(path: str | Path, patterns: Iterable[str] = ("*",)) -> str:
    """Return a digest of a file, or of the names and contents of the files in a folder.

    Args:
        path: file or folder.
        patterns: patterns of `Path.rglob` of the files in a folder.
    """
    path = Path(path)
    if path.is_dir():
        paths = sorted({one for pattern in patterns for one in path.rglob(pattern)})
        files = [one for one in paths if one.is_file()]
        lines = (f"{one.relative_to(path).as_posix()} {path_digest(one)}" for one in files)
        return text_digest("\n".join(lines))
    return hashlib.blake2b(path.read_bytes(), digest_size=12).hexdigest()

"""The folder in which the machine code of kernels is cached."""

from __future__ import annotations

import hashlib
import os
from functools import lru_cache
from pathlib import Path


@lru_cache
def cache_folder(source: Path) -> str:
    """Return the folder for the machine code of all kernels in a folder, made if need be.

    It is in `NUMBA_CACHE_DIR` if that is set, else beside the kernels or in the user's cache
    folder, whichever can be written first; an empty text when none can.

    Args:
        source: the kernels' folder.
    """
    files = [*sorted(source.glob("*.py")), Path(__file__).with_name("compile.py")]
    text = b"".join(path.read_bytes() for path in files)
    name = f"wbc-kernels-{hashlib.sha256(text).hexdigest()[:16]}"
    asked = os.environ.get("NUMBA_CACHE_DIR")
    users = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    for parent in [Path(asked)] if asked else [source / "__pycache__", users / "wbc"]:
        folder = parent / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return str(folder)
    return ""

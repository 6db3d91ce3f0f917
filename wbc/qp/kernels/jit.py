"""How the kernels are compiled: ahead of the first tick, and kept on disk."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., Any])

# Sums may be reordered, for the vector units; NaN and infinity keep their meaning. A division
# by zero gives infinity, as numpy's does, instead of a branch to an exception.
_OPTIONS: dict[str, Any] = {
    "fastmath": {"reassoc", "contract", "nsz"},
    "error_model": "numpy",
}


def kernel(signature: str) -> Callable[[F], F]:
    """Compile a function for one signature when its module is imported.

    The machine code is kept beside the module or in the user's cache folder; where neither can
    be written it is compiled in every process.
    """

    def compiled(function: F) -> F:
        with _cache_by_content() as cached:
            made: F = numba.njit(signature, cache=cached, no_cfunc_wrapper=True, **_OPTIONS)(
                function
            )
        return made

    return compiled


def subkernel(function: F) -> F:
    """Compile a function that only kernels call."""
    # What is called from nowhere else needs no wrappers, which take long to compile. Inlined,
    # because the code that was just compiled would call a copy that is optimised differently from
    # the one that is kept on disk: the same tick would round differently in the next process.
    made: F = numba.njit(
        no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True, **_OPTIONS
    )(function)
    return made


@contextmanager
def _cache_by_content() -> Iterator[bool]:
    """Have Numba keep machine code in a folder named after the text of all kernels.

    Left alone it looks at the date of the kernel's own file, and runs old code when a part in
    another file was changed.

    Yields:
        Whether there is such a folder.
    """
    before = numba.config.CACHE_DIR
    folder = _folder(before)
    numba.config.CACHE_DIR = folder or before
    try:
        yield bool(folder)
    finally:
        numba.config.CACHE_DIR = before


@lru_cache
def _folder(asked: str) -> str:
    """The first of Numba's cache folder (if one was asked for), here, or the user's that works."""
    here = Path(__file__).parent
    text = b"".join(path.read_bytes() for path in sorted(here.glob("*.py")))
    name = f"wbc-kernels-{hashlib.sha256(text).hexdigest()[:16]}"
    users = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    for parent in [Path(asked)] if asked else [here / "__pycache__", users / "wbc"]:
        folder = parent / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return str(folder)
    return ""

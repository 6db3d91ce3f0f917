"""Compilation of kernels when their module is imported, with a cache on disk.

Without Numba, or with one that cannot compile, the decorators return the function as it is: plain
Python.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar, cast

from wbc.jit.cache import cache_folder

try:
    import numba
except ImportError:
    numba = None

F = TypeVar("F", bound=Callable[..., Any])

# Sums may be reordered, for the vector units; NaN and infinity keep their meaning. A division
# by zero gives infinity, as numpy's does, instead of a branch to an exception.
_OPTIONS: dict[str, Any] = {
    "fastmath": {"reassoc", "contract", "nsz"},
    "error_model": "numpy",
}


def can_compile() -> bool:
    """Return whether kernels that are imported from now on are compiled."""
    return numba is not None


def do_without_numba() -> None:
    """Leave kernels that are imported from now on plain Python: Numba cannot compile here."""
    global numba
    numba = None


def argument_types(*examples: Any) -> tuple[Any, ...]:
    """Return the Numba types of arguments like these, as a signature for `kernel`."""
    return () if numba is None else tuple(numba.typeof(example) for example in examples)


def kernel(*signatures: str | tuple[Any, ...]) -> Callable[[F], F]:
    """Compile a function for each of its signatures when its module is imported.

    The machine code is cached beside the module or in the user's cache folder; where neither can
    be written it is compiled in every process.
    """

    def compiled(function: F) -> F:
        if numba is None:
            return function
        with _cache_by_content(Path(function.__code__.co_filename).parent) as cached:
            made: F = numba.njit([*signatures], cache=cached, no_cfunc_wrapper=True, **_OPTIONS)(
                function
            )
        return made

    return compiled


def subkernel(function: F) -> F:
    """Compile a function that only kernels call."""
    if numba is None:
        return function
    # What is called from nowhere else needs no wrappers, which take long to compile. Inlined,
    # because the code that was just compiled would call a copy that is optimised differently from
    # the one that is kept on disk: the same tick would round differently in the next process.
    made: F = numba.njit(
        no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True, **_OPTIONS
    )(function)
    return made


def subkernel_or(plain: Callable[..., None]) -> Callable[[F], F]:
    """Compile a function that only kernels call.

    Args:
        plain: does the same with numpy; it takes the function's place without Numba, where loops
            over single entries are slow.
    """

    def chosen(function: F) -> F:
        return cast(F, plain) if numba is None else subkernel(function)

    return chosen


@contextmanager
def _cache_by_content(source: Path) -> Iterator[bool]:
    """Have Numba keep machine code in a folder named after the text of all kernels of a folder.

    Left alone it looks at the date of the kernel's own file, and runs old code when a subkernel
    in another file was changed.

    Args:
        source: the kernels' folder.

    Yields:
        Whether there is such a folder.
    """
    before = numba.config.CACHE_DIR
    folder = cache_folder(source)
    numba.config.CACHE_DIR = folder or before
    try:
        yield bool(folder)
    finally:
        numba.config.CACHE_DIR = before

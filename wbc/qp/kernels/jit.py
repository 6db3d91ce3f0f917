"""How the kernels are compiled: ahead of the first tick, and kept on disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., Any])

# Sums may be reordered, for the vector units; NaN and infinity keep their meaning.
_FAST = {"reassoc", "contract", "nsz"}


def kernel(signature: Any) -> Callable[[F], F]:
    """Compile a function for one signature when its module is imported.

    The machine code is kept beside the module or in the user's cache folder; where neither can
    be written it is compiled in every process.
    """

    def compiled(function: F) -> F:
        try:
            return numba.njit(signature, cache=True, fastmath=_FAST)(function)  # type: ignore[no-any-return]
        except RuntimeError:  # "no locator available": nowhere to keep it
            return numba.njit(signature, fastmath=_FAST)(function)  # type: ignore[no-any-return]

    return compiled


def part(function: F) -> F:
    """A function that is called by kernels only."""
    return numba.njit(fastmath=_FAST)(function)  # type: ignore[no-any-return]

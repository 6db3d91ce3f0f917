"""Loads compiled kernels, reports when that takes long, and warns when it is impossible."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import threading
import time
import warnings
from collections.abc import Sequence
from pathlib import Path

from wbc.jit.cache import cache_folder

# s of computing before the notice: several times what reading kernels from the disk takes
_NOTICE_DELAY = 4.0


class KernelsUnavailable(UserWarning):
    """The compiled kernels are unavailable, so ticks take longer; the text has reason and cure."""


def load_kernels(*modules: str) -> bool:
    """Import modules with kernels; False when Numba cannot, with a `KernelsUnavailable` warning.

    After that the kernels are plain Python when they are imported again.

    The first import on a machine compiles them (about a minute), later ones read the machine
    code from the disk (about half a second, most of it Numba's own import).

    Args:
        modules: dotted names.
    """
    if all(module in sys.modules for module in modules) and "numba" in sys.modules:
        return True
    done = threading.Event()
    threading.Thread(target=_tell_when_slow, args=(done, modules[-1]), daemon=True).start()
    try:
        importlib.import_module("numba")
        from wbc.jit import compile as compilation

        if not compilation.can_compile():
            return False
        for module in modules:
            importlib.import_module(module)
    except ImportError as error:
        _warn(f"Numba cannot be imported ({error}); run  pip install numba")
        return False
    except Exception as error:  # a compiler may raise any error
        _forget_kernels(modules)
        _warn(f"Numba cannot compile them ({type(error).__name__}: {error})")
        return False
    finally:
        done.set()
    return True


def _forget_kernels(modules: Sequence[str]) -> None:
    """Have the modules beside these imported anew, as plain Python."""
    from wbc.jit import compile as compilation

    compilation.do_without_numba()
    packages = {module.rpartition(".")[0] for module in modules if ".kernels." in module}
    for name in list(sys.modules):
        if name.rpartition(".")[0] in packages:
            del sys.modules[name]


def _warn(why: str) -> None:
    warnings.warn(
        "wbc runs without its compiled kernels, with ticks about nine times as long (1 ms instead "
        f"of 0.1 ms for a walk of Talos): {why}",
        KernelsUnavailable,
        stacklevel=4,
    )


def _tell_when_slow(done: threading.Event, module: str) -> None:
    start = time.process_time()  # not the wall clock, which also counts the load of other processes
    while time.process_time() - start < _NOTICE_DELAY:
        if done.wait(0.1):
            return
    spec = importlib.util.find_spec(module)
    cached = spec is not None and cache_folder(Path(spec.origin or "").parent)
    often = (
        "once for this machine"
        if cached
        else "in every process, for no cache folder can be written: set NUMBA_CACHE_DIR to one"
    )
    print(f"wbc: compiling kernels, {often}: about a minute", file=sys.stderr, flush=True)

"""Loads the compiled kernels, says what it waits for, and does without them where it must."""

from __future__ import annotations

import importlib
import sys
import threading
import time
import warnings

_PATIENCE = 4.0  # s of computing before a word: several times what reading them from the disk takes


class KernelsUnavailable(UserWarning):
    """The compiled kernels cannot be had: ticks take longer; the text says why, and the cure."""


def load_kernels() -> bool:
    """Import the kernels; False when that is impossible, with a `KernelsUnavailable` warning.

    The first import on a machine compiles them (about fifteen seconds), later ones read the machine
    code from the disk (about half a second, most of it Numba's own import).
    """
    if "wbc.qp.compiled" in sys.modules and "wbc.qp.kernels.dual_active_set" in sys.modules:
        return True
    done = threading.Event()
    threading.Thread(target=_tell_when_slow, args=(done,), daemon=True).start()
    try:
        importlib.import_module("wbc.qp.compiled")
        importlib.import_module("wbc.qp.kernels.dual_active_set")
    except ImportError as error:
        _warn(f"Numba cannot be imported ({error}); run  pip install numba")
        return False
    except Exception as error:  # whatever a compiler can come up with
        _warn(f"Numba cannot compile them ({type(error).__name__}: {error})")
        return False
    finally:
        done.set()
    return True


def _warn(why: str) -> None:
    warnings.warn(
        f"wbc runs without its compiled kernels, with ticks about three times as long: {why}",
        KernelsUnavailable,
        stacklevel=4,
    )


def _tell_when_slow(done: threading.Event) -> None:
    start = time.process_time()  # not the wall clock: a busy machine is no compiler
    while time.process_time() - start < _PATIENCE:
        if done.wait(0.1):
            return
    print(
        "wbc: compiling the controller's kernels, once for this machine: about 15 s",
        file=sys.stderr,
        flush=True,
    )

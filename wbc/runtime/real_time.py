"""Requests from the system what keeps ticks on time, and restores everything afterwards.

Each request was kept because it measurably helps. Talos walking at 500 Hz on two processors under
a load of 7, overruns of 12 000 ticks: nothing asked 9 700, nice −20 with a timer slack of 1 ns
4 100, SCHED_FIFO 4. Beside a Python thread that computes for 2 ms out of 10, of 5 000 ticks:
SCHED_FIFO with a switch interval of 5 ms 1 430, with 0.2 ms 150. After the kernel had taken back
the process's pages, two ticks had 66 page faults, 4 of them from the disk; with locked pages none.
No gain was found in pinning the thread to a processor, nor in keeping processors out of their sleep
states (the loop spins while they would wake up).
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import gc
import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from wbc.errors import WbcError
from wbc.runtime.loop_conditions import LoopConditions, SystemRequest

_PR_SET_TIMERSLACK, _PR_GET_TIMERSLACK = 29, 30  # <linux/prctl.h>
_MCL_CURRENT, _MCL_ONFAULT = 1, 4  # <sys/mman.h>
_NICE = -20
#: Priority under SCHED_FIFO of a loop that is not told another.
DEFAULT_PRIORITY = 40
_LIMITS = "/etc/security/limits.conf"

Restore = Callable[[], object]


@dataclass(frozen=True, slots=True)
class RealTime:
    """The requests of a real-time loop to the system; the loop runs without what is refused.

    Attributes:
        priority: priority of the thread under SCHED_FIFO, 1 to 99; 0 requests none. None requests
            40, but none in a niced process, which is to give way to others. The kernel's interrupt
            threads have 50: below that the loop cannot keep the network or the disk from working.
        lock_memory: keep the pages in memory that are there.
        switch_interval: after which another Python thread has to give way, s.

    Raises:
        WbcError: a value is out of its range.
    """

    priority: int | None = None
    lock_memory: bool = True
    switch_interval: float = 2e-4

    def __post_init__(self) -> None:
        if self.priority is not None and not 0 <= self.priority <= 99:
            raise WbcError(f"priority = {self.priority} must be 1 to 99, or 0 for none")
        if not self.switch_interval > 0.0:
            raise WbcError(f"switch_interval = {self.switch_interval} s must be positive")


@contextlib.contextmanager
def real_time_thread(wanted: RealTime) -> Iterator[LoopConditions]:
    """Request what keeps the ticks of this thread on time; restore everything at the end.

    Yields:
        What was granted.
    """
    requests = []
    with ExitStack() as undo:

        def request(what: str, change: Callable[[], Restore], cure: str = "") -> bool:
            refusal = _refusal(undo, change, cure)
            requests.append(SystemRequest(what, refusal is None, refusal or ""))
            return refusal is None

        if wanted.lock_memory:
            request("memory locked", _lock_memory, f"needs 'memlock unlimited' in {_LIMITS}")
        level, niceness = wanted.priority, os.getpriority(os.PRIO_PROCESS, 0)
        if level is None and niceness > 0:
            cure = f"the process has nice {niceness}; ask for a priority to have it nevertheless"
            requests.append(SystemRequest(f"SCHED_FIFO {DEFAULT_PRIORITY}", False, cure))
            level = 0
        elif level is None:
            level = DEFAULT_PRIORITY
        fifo = level and request(
            f"SCHED_FIFO {level}", lambda: _set_fifo(level), f"needs 'rtprio {level}' in {_LIMITS}"
        )
        if level and not fifo:
            request(f"nice {_NICE}", _set_nice, f"needs 'nice {_NICE}' in {_LIMITS}")
        if not fifo:
            request("timer slack 1 ns", _set_timer_slack)
        undo.callback(sys.setswitchinterval, sys.getswitchinterval())
        sys.setswitchinterval(wanted.switch_interval)
        switches = f"thread switches within {1e3 * wanted.switch_interval:g} ms"
        yield LoopConditions((*requests, SystemRequest(switches, True)))


def _refusal(undo: ExitStack, change: Callable[[], Restore], cure: str) -> str | None:
    """Make a change that `undo` restores; return why the system refused it, or None."""
    if sys.platform != "linux":
        return "only Linux has it"
    try:
        undo.callback(change())
    except OSError as error:
        return cure if error.errno in (errno.EPERM, errno.ENOMEM, errno.EAGAIN) else error.strerror
    return None


def _set_fifo(priority: int) -> Restore:
    if len(os.sched_getaffinity(0)) < 2:
        raise OSError(errno.EBUSY, "with one processor nothing else would run")
    policy, before = os.sched_getscheduler(0), os.sched_getparam(0)
    # What the loop starts, a viewer for one, begins at ordinary priority.
    fifo = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    os.sched_setscheduler(0, fifo, os.sched_param(priority))

    def restore() -> None:
        try:
            os.sched_setscheduler(0, policy, before)
        except OSError:  # without privileges, RESET_ON_FORK stays
            os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, before)

    return restore


def _set_nice() -> Restore:
    before = os.getpriority(os.PRIO_PROCESS, 0)
    os.setpriority(os.PRIO_PROCESS, 0, _NICE)
    return lambda: os.setpriority(os.PRIO_PROCESS, 0, before)


def _set_timer_slack() -> Restore:
    libc = ctypes.CDLL(None, use_errno=True)
    before = libc.prctl(_PR_GET_TIMERSLACK, 0, 0, 0, 0)
    if before < 0 or libc.prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0) != 0:
        raise OSError(errno.ENOTSUP, os.strerror(ctypes.get_errno()))
    return lambda: libc.prctl(_PR_SET_TIMERSLACK, before, 0, 0, 0)


def _lock_memory() -> Restore:
    if _locked_kilobytes() > 0:  # the caller's own lock, which is to last
        return lambda: None
    libc = ctypes.CDLL(None, use_errno=True)
    # Only what is mapped by now: were later mappings locked as well, an allocation in mid-tick
    # could exceed the limit and fail. On fault: what nobody has touched takes no memory.
    if libc.mlockall(_MCL_CURRENT | _MCL_ONFAULT) != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return libc.munlockall


def _locked_kilobytes() -> int:
    """Return the locked memory of this process, kB."""
    found = re.search(r"^VmLck:\s*(\d+)", Path("/proc/self/status").read_text("ascii"), re.M)
    return int(found[1]) if found else 0


@contextlib.contextmanager
def garbage_collection_paused() -> Iterator[None]:
    """Pause garbage collection: a full one takes 100 ms, and no tick creates reference cycles."""
    with ExitStack() as undo:
        if gc.isenabled():
            undo.callback(gc.enable)
        gc.collect()
        if (
            gc.get_freeze_count() == 0
        ):  # otherwise the caller has frozen objects, which must stay frozen
            gc.freeze()
            undo.callback(gc.unfreeze)
        gc.disable()
        yield

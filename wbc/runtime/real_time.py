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
import gc
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from wbc.errors import WbcError
from wbc.runtime.loop_conditions import LoopConditions, SystemRequest

_PR_SET_TIMERSLACK, _PR_GET_TIMERSLACK = 29, 30  # <linux/prctl.h>
_MCL_CURRENT, _MCL_ONFAULT = 1, 4  # <sys/mman.h>
_LIMITS = "/etc/security/limits.conf"


@dataclass(frozen=True, slots=True)
class RealTime:
    """What a real-time loop requests from the system; it goes on without what is refused.

    Attributes:
        priority: of the thread under SCHED_FIFO, 1 to 99; 0 asks for no priority at all. The
            kernel's interrupt threads have 50: below that the loop cannot keep the network or
            the disk from working.
        lock_memory: keep the pages in memory that are there.
        switch_interval: after which another Python thread has to give way, s.

    Raises:
        WbcError: a value is out of its range.
    """

    priority: int = 40
    lock_memory: bool = True
    switch_interval: float = 2e-4

    def __post_init__(self) -> None:
        if not 0 <= self.priority <= 99:
            raise WbcError(f"priority = {self.priority} must be 1 to 99, or 0 for none")
        if not self.switch_interval > 0.0:
            raise WbcError(f"switch_interval = {self.switch_interval} s must be positive")


@contextlib.contextmanager
def real_time_thread(wanted: RealTime) -> Iterator[LoopConditions]:
    """Request what keeps the ticks of this thread on time; restore everything at the end.

    Yields:
        What was granted.
    """
    with ExitStack() as undo:
        requests = []
        if wanted.lock_memory:
            requests.append(_lock_memory(undo))
        requests += _priority(wanted.priority, undo)
        requests.append(_switch_interval(wanted.switch_interval, undo))
        yield LoopConditions(tuple(requests))


@contextlib.contextmanager
def garbage_collection_paused() -> Iterator[None]:
    """Pause garbage collection: a full one takes 100 ms, and no tick creates reference cycles."""
    with ExitStack() as undo:
        if gc.isenabled():
            undo.callback(gc.enable)
        gc.collect()
        if gc.get_freeze_count() == 0:  # else somebody's own, which is to last
            gc.freeze()
            undo.callback(gc.unfreeze)
        gc.disable()
        yield


def _priority(priority: int, undo: ExitStack) -> list[SystemRequest]:
    requests = []
    if priority:
        fifo = _fifo(priority, undo)
        if fifo.granted:  # it has no use for the rest
            return [fifo]
        requests = [fifo, _nice(undo)]
    return [*requests, _timer_slack(undo)]


def _fifo(priority: int, undo: ExitStack) -> SystemRequest:
    what = f"SCHED_FIFO {priority}"
    if sys.platform != "linux":
        return SystemRequest(what, False, "only Linux has it")
    if len(os.sched_getaffinity(0)) < 2:
        return SystemRequest(what, False, "with one processor nothing else would run")
    policy, before = os.sched_getscheduler(0), os.sched_getparam(0)
    # What the loop starts, a viewer for one, begins at ordinary priority.
    fifo = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, fifo, os.sched_param(priority))
    except OSError:
        return SystemRequest(what, False, f"needs 'rtprio {priority}' in {_LIMITS}")

    def restore() -> None:
        try:
            os.sched_setscheduler(0, policy, before)
        except OSError:  # without privileges, RESET_ON_FORK stays
            os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, before)

    undo.callback(restore)
    return SystemRequest(what, True)


def _nice(undo: ExitStack, level: int = -20) -> SystemRequest:
    what = f"nice {level}"
    if sys.platform != "linux":  # where it is the whole process's
        return SystemRequest(what, False, "only Linux has it per thread")
    before = os.getpriority(os.PRIO_PROCESS, 0)
    try:
        os.setpriority(os.PRIO_PROCESS, 0, level)
    except OSError:
        return SystemRequest(what, False, f"needs 'nice {level}' in {_LIMITS}")
    undo.callback(os.setpriority, os.PRIO_PROCESS, 0, before)
    return SystemRequest(what, True)


def _timer_slack(undo: ExitStack) -> SystemRequest:
    what = "timer slack 1 ns"
    libc = _libc()
    if libc is None:
        return SystemRequest(what, False, "only Linux has it")
    before = libc.prctl(_PR_GET_TIMERSLACK, 0, 0, 0, 0)
    if before < 0 or libc.prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0) != 0:
        return SystemRequest(what, False, os.strerror(ctypes.get_errno()))
    undo.callback(libc.prctl, _PR_SET_TIMERSLACK, before, 0, 0, 0)
    return SystemRequest(what, True)


def _lock_memory(undo: ExitStack) -> SystemRequest:
    what = "memory locked"
    libc = _libc()
    if libc is None:
        return SystemRequest(what, False, "only Linux has it")
    if _locked_kilobytes() > 0:  # somebody's own, which is to last
        return SystemRequest(what, True)
    # Only what is mapped by now: were later mappings locked as well, an allocation in mid-tick
    # could exceed the limit and fail. On fault: what nobody has touched takes no memory.
    if libc.mlockall(_MCL_CURRENT | _MCL_ONFAULT) != 0:
        return SystemRequest(what, False, f"needs 'memlock unlimited' in {_LIMITS}")
    undo.callback(libc.munlockall)
    return SystemRequest(what, True)


def _switch_interval(interval: float, undo: ExitStack) -> SystemRequest:
    undo.callback(sys.setswitchinterval, sys.getswitchinterval())
    sys.setswitchinterval(interval)
    return SystemRequest(f"thread switches within {1e3 * interval:g} ms", True)


def _libc() -> ctypes.CDLL | None:
    return ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None


def _locked_kilobytes() -> int:
    """Memory of this process that is locked by now, kB."""
    for line in Path("/proc/self/status").read_text("ascii").splitlines():
        if line.startswith("VmLck:"):
            return int(line.split()[1])
    return 0

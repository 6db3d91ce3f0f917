"""Times ticks; the same code runs in every library's process.

Two clocks are read around each tick. The process's CPU clock leaves out the time in which
other programs had the core, and counts every thread, so that work moved into a second one
would not go unseen; it is the one that is compared. The wall clock stands beside it.
"""

from __future__ import annotations

import gc
import time
from typing import Protocol

import numpy as np

from peers.case import Case


class Adapter(Protocol):
    """One library, set up for one case before the timing begins.

    Attributes:
        versions: of the library and what it stands on.
    """

    versions: dict[str, str]

    def __init__(self, case: Case) -> None: ...

    def tick(self, k: int) -> object:
        """Compute the torques of the k-th state and references, as an array; this is timed."""

    def outcome(self) -> Outcome:
        """Return the solution of the last tick; this is not timed."""


class Outcome:
    """The solution of a tick.

    Attributes:
        ok: the library says that it solved its problem.
        tau: (na,) N·m.
        acceleration: (nv,) Pinocchio's v̇.
        wrenches: (2, 6) left and right sole, in sole axes; zero without contact.
    """

    __slots__ = ("acceleration", "ok", "tau", "wrenches")

    def __init__(
        self, ok: bool, tau: np.ndarray, acceleration: np.ndarray, wrenches: np.ndarray
    ) -> None:
        self.ok = ok
        self.tau = np.array(tau, dtype=float)
        self.acceleration = np.array(acceleration, dtype=float)
        self.wrenches = np.array(wrenches, dtype=float)


def time_ticks(adapter: Adapter, ticks: int, passes: int) -> tuple[np.ndarray, np.ndarray]:
    """Return CPU and wall time of every tick, ns, shape (passes, ticks), after a warm-up pass."""
    cpu = np.zeros((passes, ticks), dtype=np.int64)
    wall = np.zeros((passes, ticks), dtype=np.int64)
    tick = adapter.tick
    cpu_clock, wall_clock = time.process_time_ns, time.perf_counter_ns
    for k in range(ticks):
        tick(k)
    gc.collect()
    gc.disable()
    try:
        for n in range(passes):
            cpu_row, wall_row = cpu[n], wall[n]
            for k in range(ticks):
                wall_start = wall_clock()
                cpu_start = cpu_clock()
                tick(k)
                cpu_stop = cpu_clock()
                wall_stop = wall_clock()
                cpu_row[k] = cpu_stop - cpu_start
                wall_row[k] = wall_stop - wall_start
            gc.collect()
    finally:
        gc.enable()
    return cpu, wall


def outcomes(adapter: Adapter, ticks: int) -> dict[str, np.ndarray]:
    """Return the solutions, stacked by the fields of `Outcome`; NaN where there is none."""
    found = []
    for k in range(ticks):
        adapter.tick(k)
        found.append(adapter.outcome())
    return {name: np.array([getattr(one, name) for one in found]) for name in Outcome.__slots__}

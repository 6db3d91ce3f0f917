"""`wbc live` with one observer more, which notes when each tick ended.

    python benchmarks/shared/soak_session.py FILE SECONDS [ARGUMENTS of wbc live]

The file is an array of `TICK`, in memory that is shared with whoever reads it: it tells about the
ticks also when the process is killed.
"""

from __future__ import annotations

import contextlib
import sys
import time
from pathlib import Path

import numpy as np

from wbc.cli import main
from wbc.cli.outputs import RunOutputs
from wbc.runtime.protocols import Observer
from wbc.runtime.report import Report
from wbc.runtime.tick import Tick

#: End of a tick by the monotonic clock, s; time since the end of the tick before, s; plant time, s.
TICK = np.dtype([("ended", "f8"), ("period", "f8"), ("time", "f8"), ("run", "f8")])


class TickTimes:
    """Notes when each tick ended.

    Args:
        path: File to create.
        count: Largest number of ticks.
    """

    def __init__(self, path: Path, count: int) -> None:
        self._ticks = np.memmap(path, TICK, "w+", shape=(count,))
        self._ticks[:] = np.zeros((), TICK)  # mapped now, not in a tick
        self._count = 0
        self._first = True

    def begin(self, controller: object, plant: object) -> None:
        """The first tick of a run has no tick before it."""
        self._first = True

    def observe(self, tick: Tick) -> None:
        """Note the tick."""
        if self._count < len(self._ticks):
            period = 0.0 if self._first else tick.period
            self._ticks[self._count] = (time.monotonic(), period, tick.time, tick.run)
            self._count += 1
        self._first = False

    def end(self, report: Report) -> None:
        """Do nothing; see `wbc.runtime.protocols.Observer`."""


def observe_ticks(path: Path, count: int) -> None:
    """Add the observer to the runs of this process."""
    ticks = TickTimes(path, count)
    open_observers = RunOutputs.open_observers

    def open_with_ticks(outputs: RunOutputs, stack: contextlib.ExitStack) -> list[Observer]:
        return [*open_observers(outputs, stack), ticks]

    RunOutputs.open_observers = open_with_ticks  # type: ignore[method-assign]


if __name__ == "__main__":
    observe_ticks(Path(sys.argv[1]), round(500 * float(sys.argv[2])))
    sys.exit(main(["live", *sys.argv[3:]]))

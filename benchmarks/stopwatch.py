"""Times the ticks of a loop, and in each what its observers take of the loop's thread."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator

import numpy as np
from watched import Loop

import wbc
from wbc.clock import Clock
from wbc.protocols import Controller, Observer, Plant, Recorder
from wbc.tick import Tick


class Stopwatch:
    """Times every tick, from the end of a wait for the clock to the beginning of the next.

    Args:
        ticks: how many there will be.
    """

    def __init__(self, ticks: int) -> None:
        self._wall, self._cpu, self._paid = np.zeros((3, ticks + 1))
        self._began = (0.0, 0.0)
        self._count = -1
        self.calls: dict[str, list[float]] = {}  # of observers, CPU time, s

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """While it lasts, all waiting for a clock is noticed."""
        wait = Clock.wait

        def timed(clock: Clock) -> None:
            self._end()
            wait(clock)
            self._began = time.perf_counter(), time.thread_time()

        Clock.wait = timed  # type: ignore[method-assign]
        try:
            yield
        finally:
            Clock.wait = wait  # type: ignore[method-assign]
            self._end()

    def _end(self) -> None:
        if 0 <= self._count < len(self._wall):
            self._cpu[self._count] = time.thread_time() - self._began[1]
            self._wall[self._count] = time.perf_counter() - self._began[0]
        self._count += 1

    def pay(self, what: str, since: float | None = None) -> None:
        """An observer's call is over.

        Args:
            what: it did.
            since: CPU time at which it began; at the beginning of the tick when left out.
        """
        spent = time.thread_time() - (self._began[1] if since is None else since)
        self.calls.setdefault(what, []).append(spent)
        if 0 <= self._count < len(self._paid):
            self._paid[self._count] += spent

    def times(self, ticks: int) -> np.ndarray:
        """(3, ticks) wall, CPU and observers' CPU time, s; without the first tick and the last."""
        return np.array([part[1 : ticks - 1] for part in (self._wall, self._cpu, self._paid)])


class Timed:
    """A recorder whose calls are timed."""

    def __init__(self, recorder: Recorder, watch: Stopwatch) -> None:
        self._recorder, self._watch = recorder, watch
        self.begin, self.end = recorder.begin, recorder.end
        self._what = f"{type(recorder).__name__}.record"

    def record(self, tick: Tick, controller: Controller) -> None:
        since = time.thread_time()
        self._recorder.record(tick, controller)
        self._watch.pay(self._what, since)


class TimedViewer:
    """A viewer whose calls are timed, with the making of what it is shown.

    It stands among the recorders, too, as the last of them: from there on a tick is its own.
    """

    def __init__(self, viewer: Observer, watch: Stopwatch) -> None:
        self._viewer, self._watch = viewer, watch
        self._since = 0.0

    def begin(self, controller: Controller, plant: Plant) -> None:
        """See `wbc.protocols.Recorder`."""

    def record(self, tick: Tick, controller: Controller) -> None:
        self._since = time.thread_time()

    def show(self, snapshot: wbc.Snapshot) -> None:
        self._viewer.show(snapshot)
        self._watch.pay("viewer, a frame", self._since)

    def end(self, report: wbc.Report) -> None:
        """See `wbc.protocols.Recorder`."""


def timed(loop: Loop, watch: Stopwatch) -> None:
    """Time what each observer does in the loop's thread."""
    loop.logs = [Timed(one, watch) for one in loop.logs]
    if loop.viewer is not None:
        loop.viewer = viewer = TimedViewer(loop.viewer, watch)
        loop.logs.append(viewer)
    loop.before_tick = [_timed(call, watch) for call in loop.before_tick]


def _timed(call: Callable[[float], None], watch: Stopwatch) -> Callable[[float], None]:
    what = f"{type(call).__module__.split('.')[1]}: looking for requests"
    waits = "live" in what  # for the tick's time, before it looks

    def helm(now: float) -> None:
        since = None if waits else time.thread_time()
        call(now)
        watch.pay(what, since)

    return helm

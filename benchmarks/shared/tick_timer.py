"""Times the ticks of a loop, and the calls of its observers in the loop's thread."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from wbc.runtime.clock import Clock


class TickTimer:
    """Times every tick, from the end of a wait for the clock to the beginning of the next.

    Args:
        ticks: how many there will be.

    Attributes:
        calls: CPU time of each call of the observers, by name, s.
    """

    def __init__(self, ticks: int) -> None:
        self._wall, self._cpu = np.zeros((2, ticks + 1))
        self._began = (0.0, 0.0)
        self._count = -1
        self.calls: dict[str, list[float]] = {}

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """Detect all waits for a clock while the context lasts."""
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

    def wrap(self, what: str, call: Callable[..., None], waits: bool) -> Callable[..., None]:
        """Return an observer's call with its CPU time recorded.

        Args:
            what: Name of the call.
            call: Function to call.
            waits: Whether the call first waits for the tick's time, so that the tick begins in
                it.
        """
        calls = self.calls[what] = []

        def timed(*arguments: Any) -> None:
            since = time.thread_time()
            call(*arguments)
            if waits:
                since = self._began[1]
            calls.append(time.thread_time() - since)

        return timed

    def times(self, ticks: int) -> np.ndarray:
        """Return wall and CPU time of the ticks, s, shape (2, ticks)."""
        return np.array([self._wall[:ticks], self._cpu[:ticks]])

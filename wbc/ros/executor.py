"""Runs the callbacks of a node, in one thread, when messages arrive and timers expire."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

from wbc.ros.dds_endpoints import DdsReader

_MAX_WAIT = 0.1  # s: Ctrl-C takes effect at least as often


class Waitable(Protocol):
    """Something with a reader, whose messages are processed while the node spins.

    Attributes:
        reader: `execute` is called when this reader has received messages.
    """

    reader: DdsReader

    def execute(self) -> None:
        """Process what has been received, without blocking."""


class Timer:
    """Calls a function periodically; created by `Node.create_timer`.

    Attributes:
        period: time between two calls, s; may be changed at any time.
        callback: the function.
        next_call: time of the next call, s, on the monotonic clock.
    """

    def __init__(self, period: float, callback: Callable[[], None]) -> None:
        self.period, self.callback = period, callback
        self.next_call = time.monotonic() + period
        self._canceled = False

    def cancel(self) -> None:
        """Stop calling the function."""
        self._canceled = True

    def is_canceled(self) -> bool:
        """Return whether the timer has been canceled."""
        return self._canceled

    def call(self, now: float) -> None:
        """Call the function and schedule the next call; missed calls are not made up for."""
        self.next_call = max(self.next_call + self.period, now)
        self.callback()


class Executor:
    """Waits for the readers and timers of one node, and runs what is due.

    Args:
        participant: domain participant of Cyclone DDS.
    """

    def __init__(self, participant: Any) -> None:
        from cyclonedds.core import GuardCondition, WaitSet

        self._wait_set: Any = WaitSet(participant)
        # A wait set to which nothing is attached does not wait.
        self._wait_set.attach(GuardCondition(participant))
        self._waitables: list[Waitable] = []
        self._timers: list[Timer] = []
        self._open = True

    def add_waitable(self, waitable: Waitable) -> None:
        """Execute a waitable whenever its reader has received messages."""
        self._waitables.append(waitable)
        self._wait_set.attach(waitable.reader.condition)

    def remove_waitable(self, waitable: Waitable) -> None:
        """Stop executing a waitable."""
        self._waitables.remove(waitable)
        self._wait_set.detach(waitable.reader.condition)

    def add_timer(self, timer: Timer) -> None:
        """Call a timer whenever it is due, until it is canceled."""
        self._timers.append(timer)

    def spin_once(self, timeout_sec: float) -> None:
        """Wait for messages or a timer, at most `timeout_sec` s, and run what is due."""
        now = time.monotonic()
        self._timers = [timer for timer in self._timers if not timer.is_canceled()]
        wait = min([timeout_sec, *(timer.next_call - now for timer in self._timers)])
        if self._wait_set.wait(int(1e9 * max(wait, 0.0))):
            for waitable in tuple(self._waitables):
                waitable.execute()
        now = time.monotonic()
        for timer in tuple(self._timers):
            if timer.next_call <= now and not timer.is_canceled():
                timer.call(now)

    def spin_until(self, condition: Callable[[], object], timeout_sec: float) -> bool:
        """Run callbacks until a condition holds; see `Node.spin_until`."""
        end = time.monotonic() + timeout_sec
        while not condition():
            left = end - time.monotonic()
            if left <= 0.0 or not self._open:
                return False
            self.spin_once(min(left, _MAX_WAIT))
        return True

    def close(self) -> None:
        """Stop spinning, and forget waitables and timers."""
        self._open = False
        self._waitables.clear()
        self._timers.clear()

"""Runs the callbacks of a node: waits for messages and timers, one thread."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from wbc.ros.dds_endpoints import Waitable
from wbc.ros.timer import Timer

_MAX_WAIT = 0.1  # s: Ctrl-C takes effect at least as often
_PENDING_WAIT = 0.005  # s


class Executor:
    """Waits for the readers and timers of one node, and runs what is due.

    Args:
        participant: domain participant of Cyclone DDS.
    """

    def __init__(self, participant: Any) -> None:
        from cyclonedds.core import WaitSet

        self._wait_set: Any = WaitSet(participant)
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

    def spin_once(self, timeout_sec: float = _MAX_WAIT) -> None:
        """Wait for messages or a timer, at most `timeout_sec` s, and run what is due."""
        now = time.monotonic()
        if any(waitable.has_pending for waitable in self._waitables):
            timeout_sec = min(timeout_sec, _PENDING_WAIT)
        wait = min([timeout_sec, *(timer.next_call - now for timer in self._timers)])
        received = self._wait_set.wait(int(1e9 * max(wait, 0.0)))
        for waitable in tuple(self._waitables):
            if received or waitable.has_pending:
                waitable.execute()
        now = time.monotonic()
        for timer in tuple(self._timers):
            if timer.is_canceled():
                self._timers.remove(timer)
            elif timer.next_call <= now:
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

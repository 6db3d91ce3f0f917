"""Timers of a node."""

from __future__ import annotations

import time
from collections.abc import Callable


class Timer:
    """Calls a function periodically; created by `Node.create_timer`.

    Attributes:
        period: time between two calls, s; may be changed at any time.
        callback: the function.
        next_call: time of the next call, s, on the monotonic clock.
    """

    def __init__(self, period: float, callback: Callable[[], None]) -> None:
        self.period = period
        self.callback = callback
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

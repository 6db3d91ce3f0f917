"""The clock of a motion's script: letting ticks pass until something has happened."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator

from wbc.motions.engine.reference import SmoothReference

#: What `Motion.play` returns: each `yield` lets one tick pass.
Script = Generator[None, None, None]


class ScriptClock:
    """Counts ticks, and gives scripts something to wait for.

    Args:
        dt: control period, s.

    Attributes:
        dt: control period, s.
        time: since the last reset, s.
    """

    def __init__(self, dt: float) -> None:
        self.dt = dt
        self.time = 0.0

    def advance(self) -> None:
        """Count one tick."""
        self.time += self.dt

    def wait(self, seconds: float) -> Script:
        """Let a time pass, s."""
        end = self.time + seconds - 0.5 * self.dt
        while self.time < end:
            yield

    def until(self, condition: Callable[[], bool], timeout: float = math.inf) -> Script:
        """Wait until a condition holds, or until a time is over, s."""
        end = self.time + timeout
        while not condition() and self.time < end:
            yield

    def until_arrived(self, *references: SmoothReference) -> Script:
        """Wait until these references have reached their targets."""
        yield from self.until(lambda: all(r.arrived for r in references))

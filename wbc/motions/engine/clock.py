"""ScriptClock in a motion's script."""

from __future__ import annotations

import math
from collections.abc import Callable

from wbc.motions.engine.motion import Script
from wbc.motions.engine.reference import SmoothReference


class ScriptClock:
    """Lets ticks pass until something has come.

    Args:
        dt: control period, s.

    Attributes:
        dt: control period, s.
        time: since the reset, s.
    """

    def __init__(self, dt: float) -> None:
        self.dt = dt
        self.time = 0.0

    def wait(self, seconds: float) -> Script:
        """Let time pass."""
        end = self.time + seconds - 0.5 * self.dt
        while self.time < end:
            yield

    def until(self, condition: Callable[[], bool], at_most: float = math.inf) -> Script:
        """Wait for a condition, or until a time is over, s."""
        end = self.time + at_most
        while not condition() and self.time < end:
            yield

    def arrive(self, *references: SmoothReference) -> Script:
        """Wait until these references are where they were sent."""
        yield from self.until(lambda: all(r.arrived for r in references))

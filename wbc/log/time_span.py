"""The part of a run that is read from its log."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wbc.log.errors import LogError


@dataclass(frozen=True)
class TimeSpan:
    """A span of time, ends included.

    Attributes:
        start: First time, s.
        end: Last time, s.

    Raises:
        LogError: The span does not end after its start.
    """

    start: float = -math.inf
    end: float = math.inf

    def __post_init__(self) -> None:
        if not self.start < self.end:
            raise LogError(f"the span from {self.start:g} s to {self.end:g} s must end later")

    @property
    def whole(self) -> bool:
        """Whether it has no limits."""
        return math.isinf(self.start) and math.isinf(self.end)

    def overlaps(self, start: float, end: float) -> bool:
        """Return whether it has times in common with another span, in ns."""
        return start <= 1e9 * self.end and end >= 1e9 * self.start

    def __str__(self) -> str:
        """Return e.g. "1.2 s to 3.5 s"."""
        start = "the start" if math.isinf(self.start) else f"{self.start:g} s"
        return f"{start} to " + ("the end" if math.isinf(self.end) else f"{self.end:g} s")


#: Without limits.
WHOLE_RUN = TimeSpan()

"""The pace at which a node publishes what it has missed while it was held up."""

from __future__ import annotations

from dataclasses import dataclass

_FACTOR = 2.0  # rate of the missed ticks, over that of the loop
_MIN_RATE = 100.0  # Hz at which new ticks are read
_MAX_BACKLOG = 256  # ticks, above which the pace is given up: a loop without real time is faster


@dataclass(frozen=True)
class CatchUpPace:
    """Spreads missed ticks over time.

    All at once would overrun a subscription that keeps ten messages: it loses what it cannot take
    before ten more have come.

    Attributes:
        dt: control period, s.
    """

    dt: float

    def period(self, max_rate: float) -> float:
        """Return the time between two looks for new ticks, s, for the rate of a topic, Hz."""
        return 1.0 / max(2.0 * max_rate, _MIN_RATE)

    def pause(self, max_rate: float) -> float:
        """Return the time until missed ticks are read again, s: that between two messages."""
        return 2.0 * self.period(max_rate)

    def at_once(self, waiting: int, max_rate: float) -> int:
        """Return how many ticks to read at once if so many are waiting."""
        paced = max(round(_FACTOR * self.pause(max_rate) / self.dt), 1)
        return paced if waiting <= _MAX_BACKLOG else waiting

"""How many pushes were survived."""

from __future__ import annotations

_PROBATION = 3.0  # s of plant time without a fall


class PushCount:
    """Counts pushes that are decided: survived after three seconds on its feet, or not.

    Attributes:
        decided: pushes so far, those left out that a reset cut short.
        survived: how many of them.
    """

    def __init__(self) -> None:
        self.decided = self.survived = 0
        self._open: list[float] = []

    def pushed(self, time: float) -> None:
        """A push sets in at a time of the plant, s."""
        self._open.append(time)

    def tick(self, time: float) -> None:
        """Still on its feet at a time, s."""
        while self._open and time >= self._open[0] + _PROBATION:
            del self._open[0]
            self.decided += 1
            self.survived += 1

    def fell(self) -> None:
        """None of the open ones was survived."""
        self.decided += len(self._open)
        self._open.clear()

    def restart(self) -> None:
        """The plant's time starts over."""
        self._open.clear()

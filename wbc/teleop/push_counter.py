"""Counts the pushes that the robot survived."""

from __future__ import annotations

_TIME_TO_FALL = 3.0  # s of plant time without a fall, after which a push counts as survived


class PushCounter:
    """Counts the pushes that were survived: no fall within three seconds.

    Attributes:
        decided: pushes that were survived or not; those that a reset cut short are left out.
        survived: number of them that were survived.
    """

    def __init__(self) -> None:
        self.decided = self.survived = 0
        self._undecided: list[float] = []

    def on_push(self, time: float) -> None:
        """Count a push that begins at a time of the plant, s."""
        self._undecided.append(time)

    def on_tick(self, time: float) -> None:
        """Count the pushes survived by a robot that stands at a time of the plant, s."""
        while self._undecided and time >= self._undecided[0] + _TIME_TO_FALL:
            del self._undecided[0]
            self.decided += 1
            self.survived += 1

    def on_fall(self) -> None:
        """Count the undecided pushes as not survived, because the robot fell."""
        self.decided += len(self._undecided)
        self._undecided.clear()

    def on_reset(self) -> None:
        """Discard the undecided pushes: the time of the plant starts again at zero."""
        self._undecided.clear()

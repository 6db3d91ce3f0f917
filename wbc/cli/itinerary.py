"""Which velocity is commanded when: stand, walk, and stop in time to end standing."""

from __future__ import annotations

from dataclasses import dataclass

Velocity = tuple[float, float, float]

STANDING: Velocity = (0.0, 0.0, 0.0)
_FIRST = 1.0  # s of standing before the first step
_LAST = 3.0  # s for the last steps, and to stand
#: What `--tour` shows: s, and shares of the largest forward, sideways and turning speed.
_TOUR = (
    (6.0, (0.5, 0.0, 0.0)),  # forward
    (7.0, (0.4, 0.0, 0.5)),  # a curve
    (5.0, (0.0, 0.5, 0.0)),  # to the left
    (4.0, (0.0, 0.0, -0.6)),  # a turn in place
    (4.0, (-0.35, 0.0, 0.0)),  # backward
)


@dataclass(frozen=True)
class Itinerary:
    """A velocity command over time.

    Attributes:
        legs: (end in s, velocity in m/s, m/s and rad/s), in the order of time.
    """

    legs: tuple[tuple[float, Velocity], ...]

    def velocity(self, time: float) -> Velocity:
        """What is commanded at a time, s; standing after the last leg."""
        return next((velocity for end, velocity in self.legs if time < end), STANDING)


def walk(velocity: Velocity, duration: float) -> Itinerary:
    """One velocity, framed by standing."""
    start = min(_FIRST, 0.1 * duration)
    return Itinerary(((start, STANDING), (duration - min(_LAST, 0.3 * duration), velocity)))


def tour(largest: Velocity) -> Itinerary:
    """Forward, a curve, sideways, a turn in place and backward.

    Args:
        largest: forward, sideways and turning speed of the robot's gait, m/s and rad/s.
    """
    time = _FIRST
    legs = [(time, STANDING)]
    for duration, (forward, left, turn) in _TOUR:
        time += duration
        legs.append((time, (forward * largest[0], left * largest[1], turn * largest[2])))
    return Itinerary(tuple(legs))


#: How long a tour takes with its end, s.
TOUR_DURATION = _FIRST + sum(duration for duration, _ in _TOUR) + _LAST

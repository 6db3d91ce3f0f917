"""Velocity commands over time: stand, walk, and stop in time to end standing."""

from __future__ import annotations

from dataclasses import dataclass

Velocity = tuple[float, float, float]

STANDING: Velocity = (0.0, 0.0, 0.0)
_INITIAL_STAND = 1.0  # s of standing before the first step
_FINAL_STAND = 3.0  # s for the last steps, and to stand
#: The segments of `--tour`: duration, s, and the fractions of the robot's maximum velocity.
_TOUR = (
    (6.0, (0.5, 0.0, 0.0)),  # forward
    (7.0, (0.4, 0.0, 0.5)),  # a curve
    (5.0, (0.0, 0.5, 0.0)),  # to the left
    (4.0, (0.0, 0.0, -0.6)),  # a turn in place
    (4.0, (-0.35, 0.0, 0.0)),  # backward
)


@dataclass(frozen=True)
class VelocitySchedule:
    """A piecewise constant velocity command.

    Attributes:
        segments: end time, s, and velocity (forward m/s, left m/s, turn rad/s) of each segment,
            in order of time. The robot stands after the last one.
    """

    segments: tuple[tuple[float, Velocity], ...]

    def velocity(self, time: float) -> Velocity:
        """Return the velocity commanded at a time, s."""
        return next((velocity for end, velocity in self.segments if time < end), STANDING)


def walk(velocity: Velocity, duration: float) -> VelocitySchedule:
    """Return a schedule that stands, walks at one velocity and stands again.

    Args:
        velocity: forward and left, m/s, and turn, rad/s.
        duration: duration of the whole schedule, s.
    """
    start = min(_INITIAL_STAND, 0.1 * duration)
    end = duration - min(_FINAL_STAND, 0.3 * duration)
    return VelocitySchedule(((start, STANDING), (end, velocity)))


def tour(max_velocity: Velocity) -> VelocitySchedule:
    """Return a schedule that walks forward, in a curve, sideways, in place and backward.

    Args:
        max_velocity: maximum forward, sideways (m/s) and turning velocity (rad/s) of the gait.
    """
    time = _INITIAL_STAND
    segments = [(time, STANDING)]
    for duration, (forward, left, turn) in _TOUR:
        time += duration
        velocity = (forward * max_velocity[0], left * max_velocity[1], turn * max_velocity[2])
        segments.append((time, velocity))
    return VelocitySchedule(tuple(segments))


#: Duration of a tour, including the initial and final standing, s.
TOUR_DURATION = _INITIAL_STAND + sum(duration for duration, _ in _TOUR) + _FINAL_STAND

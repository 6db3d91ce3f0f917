"""A walking velocity that goes over to another one smoothly."""

from __future__ import annotations

from wbc.gait.footsteps import Velocity
from wbc.gait.parameters import GaitParameters

_TIME = 0.1  # s in which the last of the way is gone
_LAG = 0.025  # s in which the acceleration follows; a quarter of the above: no overshoot
_THERE = 1e-3  # of the greatest velocity


class VelocityFilter:
    """Goes from one velocity to another, fast from rest to the greatest in the time of a step.

    Each component is a critically damped second-order low-pass of what is wanted, its
    acceleration bounded: a wish that jumps about from tick to tick does not shake the robot.
    """

    def __init__(self) -> None:
        self._acceleration = (0.0, 0.0, 0.0)

    def reset(self) -> None:
        """Begin anew, from a velocity that does not change."""
        self._acceleration = (0.0, 0.0, 0.0)

    def update(
        self, velocity: Velocity, wanted: Velocity, share: float, dt: float, gait: GaitParameters
    ) -> Velocity:
        """The velocity after dt.

        Args:
            velocity: now.
            wanted: where to.
            share: of the bound of the acceleration that may be used.
            dt: s.
            gait: its greatest velocities and duration of a step.
        """
        now = (velocity.forward, velocity.left, velocity.turn)
        goal = (wanted.forward, wanted.left, wanted.turn)
        lag = min(dt / _LAG, 1.0)
        accelerations, reached = [], []
        for v, w, a, most in zip(now, goal, self._acceleration, gait.max_velocity, strict=True):
            bound = share * most / gait.step_duration
            a += lag * (max(-bound, min(bound, (w - v) / _TIME)) - a)
            v += a * dt
            if abs(w - v) < _THERE * most and abs(a) * _TIME < _THERE * most:
                v, a = w, 0.0
            accelerations.append(a)
            reached.append(v)
        self._acceleration = (accelerations[0], accelerations[1], accelerations[2])
        return Velocity(reached[0], reached[1], reached[2])

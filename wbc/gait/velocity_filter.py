"""Low-pass filter of the walking velocity, with bounded acceleration."""

from __future__ import annotations

from wbc.gait.footsteps import Velocity
from wbc.gait.parameters import GaitParameters

_TIME = 0.1  # s, time constant of the velocity
_LAG = 0.025  # s, of the acceleration; a quarter of the above: critically damped
_TOLERANCE = 1e-3  # share of the largest velocity below which the difference is dropped


class VelocityFilter:
    """Filters a velocity command that may jump from tick to tick.

    Each component is a critically damped second-order low-pass of the command. Its
    acceleration is bounded to the largest velocity over the duration of a step, forward to
    `GaitParameters.velocity_change` over it.
    """

    def __init__(self) -> None:
        self._acceleration = (0.0, 0.0, 0.0)

    def reset(self) -> None:
        """Start anew, with zero acceleration."""
        self._acceleration = (0.0, 0.0, 0.0)

    def update(
        self, velocity: Velocity, wanted: Velocity, share: float, dt: float, gait: GaitParameters
    ) -> Velocity:
        """Return the velocity after dt.

        Args:
            velocity: present velocity.
            wanted: commanded velocity.
            share: usable share of the acceleration bound, 0 to 1.
            dt: time since the last tick, s.
            gait: largest velocities and duration of a step.
        """
        now = (velocity.forward, velocity.left, velocity.turn)
        goal = (wanted.forward, wanted.left, wanted.turn)
        lag = min(dt / _LAG, 1.0)
        forward, left, turn = gait.max_velocity.largest
        limits = (min(forward, gait.velocity_change), left, turn)
        accelerations, reached = [], []
        for v, w, a, most in zip(now, goal, self._acceleration, limits, strict=True):
            bound = share * most / gait.step_duration
            a += lag * (max(-bound, min(bound, (w - v) / _TIME)) - a)
            v += a * dt
            if abs(w - v) < _TOLERANCE * most and abs(a) * _TIME < _TOLERANCE * most:
                v, a = w, 0.0
            accelerations.append(a)
            reached.append(v)
        self._acceleration = (accelerations[0], accelerations[1], accelerations[2])
        return Velocity(reached[0], reached[1], reached[2])

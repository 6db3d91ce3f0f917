"""The set of velocities that a gait can walk at."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class VelocityLimits:
    """Velocities within an ellipsoid: `(v_x/a)² + (v_y/b)² + (ω/c)² ≤ 1`.

    The legs that make a long step have less left to make it wide or to turn, so the limits of the
    directions hold one at a time; together they hold as an ellipsoid. Backward has its own. A limit
    of 0 excludes a direction.

    Attributes:
        forward: largest forward velocity, m/s.
        backward: largest backward velocity, m/s.
        left: largest velocity to either side, m/s.
        turn: largest rate of turning, rad/s.
    """

    forward: float = math.inf
    backward: float = math.inf
    left: float = math.inf
    turn: float = math.inf

    @property
    def largest(self) -> tuple[float, float, float]:
        """Largest forward, left (m/s) and turn (rad/s), one at a time."""
        return (self.forward, self.left, self.turn)

    def usage(self, forward: float, left: float, turn: float) -> float:
        """How much of the limits a velocity (m/s, m/s, rad/s) uses; above 1 it is beyond them."""
        return math.hypot(
            _ratio(forward, self.forward if forward >= 0.0 else self.backward),
            _ratio(left, self.left),
            _ratio(turn, self.turn),
        )

    def clamp(self, forward: float, left: float, turn: float) -> tuple[float, float, float]:
        """Return the largest velocity in the direction of one, at most that one itself.

        Directions that are excluded are left out of it.
        """
        forward = forward if (self.forward if forward >= 0.0 else self.backward) else 0.0
        left, turn = left if self.left else 0.0, turn if self.turn else 0.0
        scale = 1.0 / max(1.0, self.usage(forward, left, turn))
        return (scale * forward, scale * left, scale * turn)

    def scaled(self, share: float) -> VelocityLimits:
        """Return a share of the limits."""
        return VelocityLimits(
            share * self.forward, share * self.backward, share * self.left, share * self.turn
        )

    def within(self, other: VelocityLimits) -> VelocityLimits:
        """Return the smaller limit in each direction."""
        return VelocityLimits(
            min(self.forward, other.forward),
            min(self.backward, other.backward),
            min(self.left, other.left),
            min(self.turn, other.turn),
        )


def _ratio(value: float, limit: float) -> float:
    if limit:
        return value / limit
    return math.inf if value else 0.0

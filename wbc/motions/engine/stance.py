"""Which feet carry the robot, where its weight is, and what that allows the CoM."""

from __future__ import annotations

import numpy as np

from wbc.gait import STAND
from wbc.geometry.planar import planar_rotation
from wbc.geometry.polygon import convex_hull, sole_corners
from wbc.motions.engine.reference import SmoothReference
from wbc.robot.upper_body import Side
from wbc.walking import Walker

_LOWEST = 0.62  # of the pelvis' height when standing; 0.6 counts as a fall


class Stance:
    """The feet on the ground and the distribution of the weight between them.

    Args:
        walker: the walker that balances.

    Attributes:
        weight_shift: (1,) where the weight is: 0 over the right sole, 0.5 in the middle, 1 over
            the left sole.
    """

    def __init__(self, walker: Walker) -> None:
        self._walker = walker
        self.weight_shift = SmoothReference(0.5, speed=1.0, acceleration=2.5)

    @property
    def standing(self) -> bool:
        """Whether both feet are on the ground and the robot is not about to walk."""
        return self._walker.gait_state.phase is STAND

    @property
    def lifted(self) -> Side | None:
        """The side of the foot that a motion holds up; None for neither."""
        state = self._walker.gait_state
        if state.lifted is None:
            return None
        return "left" if state.swing_side == "left" else "right"

    @property
    def at_rest(self) -> bool:
        """Whether the robot stands, on one leg or two."""
        return self.standing or self.lifted is not None

    @property
    def may_walk(self) -> bool:
        """Whether no foot is lifted and the weight is in the middle; the robot may be walking."""
        return self.lifted is None and self.weight_shift.value[0] == 0.5

    def polygon(self) -> list[complex]:
        """Return the support polygon, counter-clockwise, m; empty while the robot steps.

        Standing axes; the origin is the CoM's place at rest, which lies between the soles'
        centres by the share `weight_shift`.
        """
        if not self.at_rest:
            return []
        walker, lifted = self._walker, self.lifted
        feet, to_heading = walker.feet, planar_rotation(-walker.heading)
        right, left = feet.right.point, feet.left.point
        middle = right + float(self.weight_shift.value[0]) * (left - right)
        extension = walker.stabilizer.support.extension or (0j,)
        return convex_hull(
            [
                (corner + added - middle) * to_heading
                for added in extension
                for sole in walker.robot.soles
                if sole.side != lifted
                for corner in sole_corners(feet.of(sole.side), sole.half_length, sole.half_width)
            ]
        )

    def descent(self, q: np.ndarray) -> float:
        """Return how far the pelvis may sink before it nearly counts as a fall, m.

        Args:
            q: (nq,) configuration now.
        """
        height = float(q[2]) - self._walker.feet.left.height
        return height - _LOWEST * float(self._walker.robot.q_nominal[2])

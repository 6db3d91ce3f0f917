"""The moment about the vertical that a swing leg asks for, and what bears it."""

from __future__ import annotations

import math

from wbc.gait.kernels.swing import LIFT
from wbc.gait.limb_momentum import arm_yaw_momentum, swing_momentum
from wbc.geometry.quintic import PEAK_ACCELERATION
from wbc.robot import Robot
from wbc.robot.posture import has_soles

_FRICTION = 0.4  # of the ground
_GRIP = 0.45  # share of the friction's moment about the vertical for the swing leg
_ARM_SWING = 0.5  # rad by which the arms' joints swing at most, against the legs


class YawMoment:
    """What a swing leg needs about the vertical, and what sole and arms have for it.

    A foot that accelerates by a changes the angular momentum about the vertical by `κ_z a`. The
    support sole transmits as much as its friction holds. What it lacks, arms can take that swing
    against the legs, harmonically, once in two steps.

    Args:
        robot: the robot.

    Attributes:
        arm_momentum: see `arm_yaw_momentum`, kg·m².
    """

    def __init__(self, robot: Robot) -> None:
        self._ratio = abs(float(swing_momentum(robot)[2, 0]))
        self._grip = math.inf  # a point turns whatever the step, and the next turns it back
        if has_soles(robot.soles):
            size = min(s.half_length + s.half_width for s in robot.soles)
            self._grip = _GRIP * _FRICTION * size * robot.weight
        self.arm_momentum = arm_yaw_momentum(robot)
        self._arms = _ARM_SWING * self.arm_momentum

    def beyond_sole(self, step_length: float, swing: float) -> float:
        """Return the share of the moment that the sole does not transmit, 0 to 1.

        Args:
            step_length: m.
            swing: duration of a swing, s.
        """
        needed = self._needed(step_length, swing)
        return max(1.0 - self._grip / needed, 0.0) if needed > 0.0 else 0.0

    def excess(self, step_length: float, swing: float, step_duration: float) -> float:
        """Return by how much the moment is beyond what sole and arms have, N·m; ≤ 0: within.

        Args:
            step_length: m.
            swing: duration of a swing, s.
            step_duration: time from step to step, s; infinite for arms that do not swing.
        """
        arms = self._arms * (math.pi / step_duration) ** 2
        return max(self._needed(step_length, swing) - arms, 0.0) - self._grip

    def _needed(self, step_length: float, swing: float) -> float:
        return (
            self._ratio * PEAK_ACCELERATION * 2.0 * abs(step_length) / ((1.0 - LIFT) * swing) ** 2
        )

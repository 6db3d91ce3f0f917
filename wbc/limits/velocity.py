"""Joint velocity limit."""

from __future__ import annotations

import numpy as np

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.limits.limit import AccelerationBound, per_joint
from wbc.robot import Robot


class JointVelocityLimit(AccelerationBound):
    """`(−v_max − q̇) / T ≤ q̈ ≤ (v_max − q̇) / T`.

    Args:
        robot: the robot.
        maximum: rad/s, a number or (na,); the robot's own limits when left out.
        horizon: T, the time over which a violation is corrected, s.

    Raises:
        LimitError: wrong shape, or an entry or horizon that is not positive.
    """

    name = "joint velocity limit"

    def __init__(
        self,
        robot: Robot,
        maximum: float | np.ndarray | None = None,
        *,
        horizon: float = 0.02,
    ) -> None:
        if not horizon > 0.0:
            raise LimitError(f"{self.name}: horizon {horizon} must be positive")
        self.maximum = per_joint(
            self.name, "maximum", robot.v_max if maximum is None else maximum, robot
        )
        self.horizon = horizon

    def bounds(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        v = kin.state.v[6:]
        return (-self.maximum - v) / self.horizon, (self.maximum - v) / self.horizon

"""Joint acceleration limit."""

from __future__ import annotations

import numpy as np

from wbc.formatting import format_range
from wbc.kinematics import Kinematics
from wbc.limits.acceleration_bound import AccelerationBound
from wbc.limits.per_joint import per_joint
from wbc.robot import RobotModel


class JointAccelerationLimit(AccelerationBound):
    """`−a_max ≤ q̈ ≤ a_max`.

    Args:
        robot: the robot.
        maximum: rad/s², a number or (na,).

    Raises:
        LimitError: wrong shape or an entry that is not positive.
    """

    name = "joint acceleration limit"

    def __init__(self, robot: RobotModel, maximum: float | np.ndarray = 500.0) -> None:
        self.maximum = per_joint(self.name, "maximum", maximum, robot)

    def __repr__(self) -> str:
        return f"JointAccelerationLimit({format_range(self.maximum, self.unit)})"

    def bounds(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        """See `AccelerationBound`."""
        return -self.maximum, self.maximum

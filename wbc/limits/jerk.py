"""Joint jerk limit."""

from __future__ import annotations

import math

import numpy as np

from wbc.errors import LimitError
from wbc.formatting import format_range
from wbc.kinematics import Kinematics
from wbc.limits.acceleration_bound import AccelerationBound
from wbc.limits.per_joint import per_joint
from wbc.robot import RobotModel


class JointJerkLimit(AccelerationBound):
    """`|q̈ − q̈ before| ≤ j_max dt`: the acceleration changes slowly from step to step.

    Where it excludes what a limit on positions, velocities or accelerations demands, that other
    limit holds: a joint that meets its stop brakes as hard as it must.

    Args:
        robot: the robot.
        maximum: j_max, rad/s³, a number or (na,).
        dt: control period, s; inverse kinematics takes the duration of the step instead.

    Raises:
        LimitError: wrong shape, or an entry or period that is not positive.
    """

    name = "joint jerk limit"

    def __init__(
        self, robot: RobotModel, maximum: float | np.ndarray = 1e4, *, dt: float = 0.002
    ) -> None:
        if not 0.0 < dt < math.inf:
            raise LimitError(f"{self.name}: dt {dt} s must be positive: it is the control period")
        self.maximum = per_joint(self.name, "maximum", maximum, robot)
        self.dt = dt

    def __repr__(self) -> str:
        return f"JointJerkLimit({format_range(self.maximum, 'rad/s³')})"

    def bounds(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        """See `AccelerationBound`."""
        before, change = kin.previous_acceleration[6:], self.dt * self.maximum
        return before - change, before + change

    def velocity_bounds(
        self, kin: Kinematics, v: np.ndarray, dt: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """See `AccelerationBound`."""
        middle, change = v + dt * kin.previous_acceleration[6:], dt * dt * self.maximum
        return middle - change, middle + change

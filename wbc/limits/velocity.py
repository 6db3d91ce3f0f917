"""Joint velocity limit."""

from __future__ import annotations

import numpy as np

from wbc.formatting import format_range
from wbc.kinematics import Kinematics
from wbc.limits.acceleration_bound import AccelerationBound
from wbc.limits.per_joint import default_braking, per_joint
from wbc.robot import RobotModel


class JointVelocityLimit(AccelerationBound):
    """`(−v_max − q̇) / T ≤ q̈ ≤ (v_max − q̇) / T`, but never demanding more than `braking`.

    Args:
        robot: the robot.
        maximum: v_max, rad/s, a number or (na,); the robot's own limits when left out.
        horizon: T, the time over which a violation is corrected, s; not shorter than the
            control period.
        braking: largest deceleration that is demanded of a joint that is too fast, rad/s², a number
            or (na,); `default_braking` when left out.

    Raises:
        LimitError: wrong shape, or an entry, horizon or braking that is not positive.
    """

    name = "joint velocity limit"

    def __init__(
        self,
        robot: RobotModel,
        maximum: float | np.ndarray | None = None,
        *,
        horizon: float = 0.02,
        braking: float | np.ndarray | None = None,
    ) -> None:
        super().__init__(horizon)
        self.maximum = per_joint(
            self.name, "maximum", robot.v_max if maximum is None else maximum, robot
        )
        braking = default_braking(robot) if braking is None else braking
        self.braking = per_joint(self.name, "braking", braking, robot)

    def __repr__(self) -> str:
        maximum = format_range(self.maximum, "rad/s")
        return f"JointVelocityLimit({maximum}, horizon {self.horizon:g} s)"

    def velocity_bounds(
        self, kin: Kinematics, v: np.ndarray, dt: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """See `AccelerationBound`: ∓ v_max."""
        return -self.maximum, self.maximum

    def bounds(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        """See `AccelerationBound`."""
        v = kin.state.v[6:]
        rate = 1.0 / self.horizon
        low = (-self.maximum - v) * rate
        high = (self.maximum - v) * rate
        np.minimum(low, self.braking, out=low)
        np.maximum(high, -self.braking, out=high)
        return low, high

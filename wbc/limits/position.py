"""Joint position limit with braking distance."""

from __future__ import annotations

import numpy as np

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.limits.limit import AccelerationBound, per_joint
from wbc.robot import Robot


_MOST_BRAKING = 20.0  # rad/s²


class JointPositionLimit(AccelerationBound):
    """Keeps every joint able to stop before its limit.

    With d the distance to the upper limit (less a margin), the velocity must not
    exceed what a deceleration a_brake can stop within d, and must bring a joint
    that is beyond the limit back:

        v_max(d) = min(√(2 a_brake d), d / T)  for d ≥ 0,   d / T  for d < 0,
        q̈ ≤ (v_max(d) − q̇) / T,

    and likewise for the lower limit (after Del Prete, Joint position and velocity
    bounds in discrete-time acceleration/torque control of robot manipulators, RA-L
    2018). T is the time over which a violation is corrected: several control periods,
    so that measurement noise does not turn into acceleration noise. Never more than
    a_brake is asked for, which a joint's motor must be able to deliver: a limit that asks
    for more than the torque limit gives would leave the QP without a solution.

    Args:
        robot: the robot.
        margin: distance kept from the limits, rad.
        braking: a_brake, rad/s², a number or (na,); when left out, what half of the joint's
            torque limit gives the limb beyond it in the nominal posture, at most 20 rad/s².
        horizon: T, s.

    Raises:
        LimitError: a negative margin, or a horizon or braking that is not positive.
    """

    name = "joint position limit"

    def __init__(
        self,
        robot: Robot,
        *,
        margin: float = 0.02,
        braking: float | np.ndarray | None = None,
        horizon: float = 0.02,
    ) -> None:
        if not horizon > 0.0 or not margin >= 0.0:
            raise LimitError(f"{self.name}: need horizon ({horizon}) > 0 and margin ({margin}) ≥ 0")
        # A joint with little play keeps at least half of it.
        margins = np.minimum(margin, 0.25 * (robot.q_max - robot.q_min))
        self.lower = robot.q_min + margins
        self.upper = robot.q_max - margins
        if braking is None:
            inertia = np.diag(Kinematics(robot, robot.standing()).mass_matrix)[6:]
            braking = np.minimum(_MOST_BRAKING, 0.5 * robot.tau_max / inertia)
        self.braking = per_joint(self.name, "braking", braking, robot)
        self.horizon = horizon

    def bounds(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        q, v = kin.state.q[7:], kin.state.v[6:]
        lower = (-self._speed(q - self.lower) - v) / self.horizon
        upper = (self._speed(self.upper - q) - v) / self.horizon
        return np.minimum(lower, self.braking), np.maximum(upper, -self.braking)

    def _speed(self, distance: np.ndarray) -> np.ndarray:
        stop = np.sqrt(2.0 * self.braking * np.maximum(distance, 0.0))
        return np.where(distance > 0.0, np.minimum(stop, distance / self.horizon), distance / self.horizon)

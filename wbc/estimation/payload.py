"""The mass of a payload, from the forces on the feet or on the hand that carries it."""

from __future__ import annotations

import math

import numpy as np

from wbc.errors import MeasurementError
from wbc.estimation.estimate import Estimate
from wbc.kinematics import Kinematics
from wbc.robot import Robot

_LEAST_SHARE = 0.005  # of the robot's mass: a payload that is no noise
_FIRST = 0.1  # s of readings that the first ones are averaged with


class PayloadEstimator:
    """Estimates an unknown mass that the robot carries.

    With foot force sensors: what the ground carries beyond the robot is the payload,

        m̂ g = low-pass( Σ f_z − m (g + z̈) ),

    where the mean of m z̈ is the change of the vertical momentum m ż of the robot. Without them: the
    vertical force on the hand, as the torques of its arm tell it (`HandForceEstimator`).

    Args:
        robot: the robot, without the payload.
        dt: period of `update`, s.
        time_constant: of the low-pass, s; some steps, of a robot that walks.

    Attributes:
        mass: m̂, kg; not negative.
        settled: whether it carries something, and has for four time constants.

    Raises:
        MeasurementError: the time constant is not positive.
    """

    def __init__(self, robot: Robot, dt: float, *, time_constant: float = 0.7) -> None:
        if not (math.isfinite(time_constant) and time_constant > 0.0):
            raise MeasurementError(
                f"PayloadEstimator: time_constant = {time_constant} s must be positive"
            )
        self._robot, self._dt, self._time = robot, dt, time_constant
        self.reset()

    def reset(self) -> None:
        """Start anew, without a payload."""
        self.mass = 0.0
        self._mean = 0.0
        self._momentum: float | None = None
        self._elapsed = self._since = 0.0

    @property
    def settled(self) -> bool:
        """Whether it carries something, and has for four time constants."""
        return self._since >= 4.0 * self._time

    def update(self, estimate: Estimate, kin: Kinematics, hand_force: np.ndarray) -> float:
        """Take in a tick; return `mass`.

        Args:
            estimate: with the wrenches on the feet, if they are measured.
            kin: its kinematics.
            hand_force: (3,) force of the payload on the hand, world axes, N; counts only without
                foot sensors.
        """
        robot, dt = self._robot, self._dt
        self._elapsed += dt
        share = dt / min(self._time, _FIRST + self._elapsed)
        momentum = robot.mass * float(kin.v_com[2])
        if estimate.foot_wrenches:
            carried = sum(
                float(kin.frame(sole.frame_id).rotation[2] @ estimate.foot_wrenches[sole.name][:3])
                for sole in robot.soles
            )
            rate = 0.0 if self._momentum is None else (momentum - self._momentum) / dt
            excess = carried - robot.weight - rate
        else:
            excess = -float(hand_force[2])
        self._momentum = momentum
        self._mean += share * (excess - self._mean)
        self.mass = max(self._mean / robot.gravity, 0.0)
        self._since = self._since + dt if self.mass > _LEAST_SHARE * robot.mass else 0.0
        return self.mass

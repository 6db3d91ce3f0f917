"""Joints that move in a fixed ratio."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from wbc.errors import TaskError
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel
from wbc.tasks.function import FunctionRows, FunctionTask


class JointCouplingTask(FunctionTask):
    """Keep a weighted sum of joint positions, `Σ cᵢ qᵢ = target`.

    With priority 0 it is the equation of a gear or of a mimic joint: `q₁ = r q₂ + offset` is
    `{"joint_1": 1.0, "joint_2": -r}` with the target `offset`.

    Args:
        robot: the robot.
        coefficients: joint name -> cᵢ.
        target: value of the sum, rad or m.

    Attributes:
        coefficients: (na,) cᵢ, 0 for other joints.
        target: value of the sum, rad or m.

    Raises:
        JointNotFound: one of the names is missing.
        TaskError: there is no coefficient but zeros, one is not finite, or see `Task`.
    """

    unit = "rad/s²"

    def __init__(
        self,
        robot: RobotModel,
        coefficients: Mapping[str, float],
        target: float = 0.0,
        *,
        weight: float | np.ndarray = 100.0,
        kp: float | np.ndarray = 100.0,
        kd: float | np.ndarray | None = None,
        priority: int = 1,
        name: str = "",
    ) -> None:
        super().__init__(name or f"{' and '.join(coefficients)}", 1, weight, kp, kd, priority)
        self.coefficients = np.zeros(robot.na)
        for joint, coefficient in coefficients.items():
            self.coefficients[robot.joint_index(joint)] = coefficient
        if not (np.isfinite(self.coefficients).all() and self.coefficients.any()):
            raise TaskError(
                f"task '{self.name}': coefficients {dict(coefficients)} must be finite numbers, "
                "not all of them zero"
            )
        if not math.isfinite(target):
            raise TaskError(f"task '{self.name}': target is {target}, it must be finite")
        self.target = float(target)

    def _format_target(self) -> str:
        return f"{self.target:g} rad"

    def write_function(self, kin: Kinematics, rows: FunctionRows) -> None:
        """See `FunctionTask.write_function`."""
        rows.J[0, :6], rows.J[0, 6:] = 0.0, self.coefficients
        rows.error[0] = self.target - self.coefficients.dot(kin.state.q[7:])

"""Joint torque limit."""

from __future__ import annotations

import numpy as np

from wbc.formatting import format_range
from wbc.limits.per_joint import per_joint
from wbc.robot import RobotModel


class TorqueLimit:
    """`−τ_max ≤ M_a v̇ + h_a − J_aᵀ f ≤ τ_max`.

    Args:
        robot: the robot.
        maximum: N·m, a number or (na,); the robot's own limits when left out.
        scale: factor on `maximum`.

    Raises:
        LimitError: wrong shape or an entry that is not positive.
    """

    name = "torque limit"
    unit = "N·m"

    def __init__(
        self, robot: RobotModel, maximum: float | np.ndarray | None = None, *, scale: float = 1.0
    ) -> None:
        limit = np.asarray(robot.tau_max if maximum is None else maximum, dtype=float)
        self.maximum = per_joint(self.name, "maximum", limit * scale, robot)

    def __repr__(self) -> str:
        return f"TorqueLimit({format_range(self.maximum, self.unit)})"

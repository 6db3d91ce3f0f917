"""Centroidal angular momentum task."""

from __future__ import annotations

import numpy as np

from wbc.formatting import format_vector
from wbc.kinematics import Kinematics
from wbc.tasks.motion import MotionTask, TaskReference


class AngularMomentumTask(MotionTask):
    """Regulate the angular momentum about the centre of mass.

    `J_L v̇ = L̇_ref + kp (L_ref − L) − J̇_L v`, world axes (Orin, Goswami and Lee,
    Centroidal dynamics of a humanoid robot, Autonomous Robots, 2013).

    Attributes:
        target: (3,) kg·m²/s.
        rate: (3,) feed-forward L̇_ref, N·m.

    Raises:
        TaskError: see `Task`.
    """

    unit = "N·m"
    components = slice(3, 6)

    def __init__(
        self,
        *,
        weight: float | np.ndarray = 0.1,
        kp: float | np.ndarray = 5.0,
        priority: int = 1,
        name: str = "angular momentum",
    ) -> None:
        super().__init__(name, weight, kp, 0.0, priority)
        self.labels = ("x", "y", "z")
        self.target = np.zeros(3)
        self.rate = np.zeros(3)

    def _format_target(self) -> str:
        return format_vector(self.target, "kg·m²/s")

    def write_reference(self, kin: Kinematics, reference: TaskReference) -> None:
        """See `MotionTask.write_reference`."""
        reference.position[:] = self.target
        reference.acceleration[:] = self.rate

    def write_velocity(
        self, kin: Kinematics, J: np.ndarray, velocity: np.ndarray, error: np.ndarray
    ) -> None:
        """Write `J_L v = L_ref`: the momentum is a velocity itself, not an error."""
        J[:] = kin.J_angular
        velocity[:] = self.target
        error[:] = 0.0

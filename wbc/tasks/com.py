"""Centre-of-mass task."""

from __future__ import annotations

import numpy as np

from wbc.formatting import format_vector
from wbc.kinematics import Kinematics
from wbc.tasks.motion import HELD, MotionTask, TaskReference


class ComTask(MotionTask):
    """Track a centre-of-mass trajectory.

    `J_com v̇ = c̈_ref + kd (ċ_ref − ċ) + kp (c_ref − c) − J̇_com v`, world axes.

    Attributes:
        target: (3,) m; None until set: then the position where the task is
            first evaluated is held.
        velocity: (3,) reference velocity, m/s.
        acceleration: (3,) feed-forward, m/s².

    Raises:
        TaskError: see `Task`.
    """

    unit = "m/s²"
    components = slice(0, 3)

    def __init__(
        self,
        target: np.ndarray | tuple[float, float, float] | None = None,
        *,
        weight: float | np.ndarray = 100.0,
        kp: float | np.ndarray = 30.0,
        kd: float | np.ndarray | None = None,
        priority: int = 1,
        name: str = "com",
    ) -> None:
        super().__init__(name, weight, kp, kd, priority)
        self.labels = ("x", "y", "z")
        self.target = None if target is None else self._vector("target", target, 3)
        self.velocity = np.zeros(3)
        self.acceleration = np.zeros(3)

    def _format_target(self) -> str:
        return HELD if self.target is None else format_vector(self.target, "m")

    def write_reference(self, kin: Kinematics, reference: TaskReference) -> None:
        """See `MotionTask.write_reference`."""
        if self.target is None:
            self.target = kin.p_com.copy()
        reference.position[:] = self.target
        reference.velocity[:] = self.velocity
        reference.acceleration[:] = self.acceleration

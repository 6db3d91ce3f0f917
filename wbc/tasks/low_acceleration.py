"""Smooth motion of the joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wbc.errors import TaskError
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel
from wbc.tasks.task import JointTask


class LowAccelerationTask(JointTask):
    """Keep the joints' velocities as they are, or damp them.

    In accelerations `q̈ = −kd q̇`, in velocities `q̇ = q̇ before the step`. With kd = 0 it spreads
    what other tasks ask for over time, with kd > 0 it also takes up motion that no task
    needs.

    Args:
        robot: the robot.
        joints: names; all actuated joints when left out.
        weight: a number or (m,).
        kd: damping, 1/s.

    Raises:
        JointNotFound: one of the names is missing.
        TaskError: a joint is given twice, or see `Task`.
    """

    unit = "rad/s²"

    def __init__(
        self,
        robot: RobotModel,
        *,
        joints: Sequence[str] | None = None,
        weight: float | np.ndarray = 0.1,
        kd: float | np.ndarray = 0.0,
        priority: int = 1,
        name: str = "low acceleration",
    ) -> None:
        labels = tuple(robot.joint_names if joints is None else joints)
        if len(set(labels)) < len(labels):
            raise TaskError(f"task '{name}': a joint is given twice: {', '.join(labels)}")
        super().__init__(name, len(labels), weight, 0.0, kd, priority)
        self.labels = labels
        self.index = np.array([robot.joint_index(joint) for joint in labels], dtype=int)

    def write_joints(self, kin: Kinematics, b: np.ndarray) -> None:
        """See `JointTask.write_joints`."""
        np.multiply(-self.kd, kin.state.v[6:][self.index], out=b)

    def write_velocity(
        self, kin: Kinematics, J: np.ndarray, velocity: np.ndarray, error: np.ndarray
    ) -> None:
        """See `Task.write_velocity`."""
        J[:] = 0.0
        J[np.arange(self.size), 6 + self.index] = 1.0
        velocity[:] = kin.previous_velocity[6:][self.index]
        error[:] = 0.0

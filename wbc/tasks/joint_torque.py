"""Joints that somebody else drives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wbc.errors import TaskError
from wbc.formatting import format_range
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel
from wbc.tasks.task import Task


class JointTorqueTask(Task):
    """Take joints as moved by known torques: those that another controller commands.

    Row by row the equation of motion of these joints, divided by their inertia,

        (M v̇)_i / M_ii = (τ_i − h_i) / M_ii + d_i,

    for joints beyond which nothing carries the robot: arms, a head. The rest of the robot then
    counts on the reaction of what they really do. The disturbance d stands for what the torques do
    not explain, e.g. an arm that leans on the trunk.

    Args:
        robot: the robot.
        joints: names of the joints.
        weight: a number or (m,); the default is above that of any other task on these joints.

    Attributes:
        target: (m,) torques τ, N·m.
        disturbance: (m,) accelerations d, rad/s².

    Raises:
        JointNotFound: one of the names is missing.
        TaskError: a joint is given twice, or see `Task`.
    """

    unit = "rad/s²"

    def __init__(
        self,
        robot: RobotModel,
        joints: Sequence[str],
        *,
        weight: float | np.ndarray = 100.0,
        priority: int = 1,
        name: str = "joint torque",
    ) -> None:
        self.index = np.array([robot.joint_index(joint) for joint in joints], dtype=int)
        if np.unique(self.index).size < self.index.size:
            raise TaskError(f"task '{name}': a joint is given twice: {', '.join(joints)}")
        super().__init__(name, self.index.size, weight, 0.0, 0.0, priority)
        self.labels = tuple(joints)
        self.target = np.zeros(self.size)
        self.disturbance = np.zeros(self.size)

    def _format_target(self) -> str:
        return f"of {self.size} joints, {format_range(np.asarray(self.target), 'N·m')}"

    def write(self, kin: Kinematics, A: np.ndarray, b: np.ndarray) -> None:
        """See `Task.write`."""
        dofs = 6 + self.index
        M = kin.mass_matrix
        inverse = 1.0 / M[dofs, dofs]
        np.multiply(M[dofs], inverse[:, None], out=A)
        np.subtract(self.target, kin.bias_forces[dofs], out=b)
        b *= inverse
        b += self.disturbance

    def write_velocity(
        self, kin: Kinematics, J: np.ndarray, velocity: np.ndarray, error: np.ndarray
    ) -> None:
        """Raise an error: torques say nothing about velocities.

        Raises:
            TaskError: always.
        """
        raise TaskError(
            f"task '{self.name}' states torques, which inverse kinematics knows nothing of; "
            "leave it out there"
        )

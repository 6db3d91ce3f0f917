"""Joint posture task."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from wbc.errors import TaskError, did_you_mean
from wbc.formatting import format_range
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel
from wbc.tasks.task import JointTask


class PostureTask(JointTask):
    """Hold or track joint positions.

    `q̈ = q̈_ref + kd (q̇_ref − q̇) + kp (q_ref − q)` for each chosen joint.

    Args:
        robot: the robot.
        target: (m,) rad, in the order of `joints`; the nominal posture when left out.
        joints: names; all actuated joints when left out.
        weight: a number, (m,), or joint name -> weight for some, with 0 for the others.

    Attributes:
        target: (m,) rad.
        velocity: (m,) rad/s.
        acceleration: (m,) rad/s².

    Raises:
        JointNotFound: one of the names is missing.
        TaskError: a wrong shape or a negative weight.
    """

    unit = "rad/s²"

    def __init__(
        self,
        robot: RobotModel,
        target: np.ndarray | None = None,
        *,
        joints: Sequence[str] | None = None,
        weight: float | np.ndarray | Mapping[str, float] = 0.3,
        kp: float | np.ndarray = 50.0,
        kd: float | np.ndarray | None = None,
        priority: int = 1,
        name: str = "posture",
    ) -> None:
        labels = tuple(robot.joint_names if joints is None else joints)
        if len(set(labels)) < len(labels):
            raise TaskError(f"task '{name}': a joint is given twice: {', '.join(labels)}")
        if isinstance(weight, Mapping):
            for joint in weight:
                if joint not in labels:
                    raise TaskError(
                        f"task '{name}': weight for '{joint}', which is not one of its joints"
                        f"{did_you_mean(joint, labels)}"
                    )
            weight = np.array([weight.get(joint, 0.0) for joint in labels])
        super().__init__(name, len(labels), weight, kp, kd, priority)
        self.labels = labels
        self.index = np.array([robot.joint_index(joint) for joint in labels], dtype=int)
        if target is None:
            target = robot.q_nominal[7:][self.index]
        self.target = self._vector("target", target, self.size)
        self.velocity = np.zeros(self.size)
        self.acceleration = np.zeros(self.size)

    def _format_target(self) -> str:
        return f"of {self.size} joints, {format_range(np.asarray(self.target), 'rad')}"

    def write_velocity(
        self, kin: Kinematics, J: np.ndarray, velocity: np.ndarray, error: np.ndarray
    ) -> None:
        """See `Task.write_velocity`."""
        J[:] = 0.0
        J[np.arange(self.size), 6 + self.index] = 1.0
        velocity[:] = self.velocity
        np.subtract(self.target, kin.state.q[7:][self.index], out=error)

    def write_joints(self, kin: Kinematics, b: np.ndarray) -> None:
        """See `JointTask.write_joints`."""
        q = kin.state.q[7:][self.index]
        v = kin.state.v[6:][self.index]
        np.subtract(self.velocity, v, out=b)
        b *= self.kd
        b += self.acceleration
        b += self.kp * (self.target - q)

"""Joint posture task."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from wbc.errors import TaskError
from wbc.kinematics import Kinematics
from wbc.robot import Robot
from wbc.tasks.task import Task


class PostureTask(Task):
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
        robot: Robot,
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
        if isinstance(weight, Mapping):
            for joint in weight:
                if joint not in labels:
                    raise TaskError(f"task '{name}': weight for '{joint}', which is not one of its joints")
            weight = np.array([weight.get(joint, 0.0) for joint in labels])
        super().__init__(name, len(labels), weight, kp, kd, priority)
        self.labels = labels
        self._index = np.array([robot.joint_index(joint) for joint in labels], dtype=int)
        if target is None:
            target = robot.q_nominal[7:][self._index]
        self.target = self._vector("target", target, self.size)
        self.velocity = np.zeros(self.size)
        self.acceleration = np.zeros(self.size)
        self._rows = np.arange(self.size)

    def write(self, kin: Kinematics, A: np.ndarray, b: np.ndarray) -> None:
        q = kin.state.q[7:][self._index]
        v = kin.state.v[6:][self._index]
        A[:] = 0.0
        A[self._rows, 6 + self._index] = 1.0
        b[:] = self.acceleration + self.kd * (self.velocity - v) + self.kp * (self.target - q)

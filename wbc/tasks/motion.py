"""Tasks on the motion of a frame or of the centroid: the base of most tasks."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np
import pinocchio as pin

from wbc.kinematics import Centroid, FrameKinematics, Kinematics
from wbc.tasks.task import Task

HELD = "held where first evaluated"  #: how `repr` shows a target that is None
CENTROID = 0  #: in place of a frame's index; frame 0 is the universe, which does not move


class TaskReference:
    """Desired pose and motion of the frame of a `MotionTask`, in world axes.

    Args:
        pose, velocity, acceleration: the arrays of the attributes.

    Attributes:
        pose: (4, 4) desired `T_world_frame`.
        rotation: (3, 3) view of the pose.
        position: (3,) view of the pose, m; of an angular momentum, kg·m²/s.
        velocity: (m,) desired velocity, the task's components, m/s and rad/s.
        acceleration: (m,) feed-forward, the task's components, m/s² and rad/s².
    """

    __slots__ = ("acceleration", "pose", "position", "rotation", "velocity")

    def __init__(self, pose: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> None:
        self.pose = pose
        self.rotation, self.position = pose[:3, :3], pose[:3, 3]
        self.velocity = velocity
        self.acceleration = acceleration

    def __reduce__(self) -> tuple[type[TaskReference], tuple[np.ndarray, ...]]:
        """Copy the arrays; the views of the pose are made again."""
        return TaskReference, (self.pose, self.velocity, self.acceleration)


class MotionTask(Task):
    """A task whose rows are components of one motion, `J v̇ = a_ref + kd (v_ref − v) + kp e − J̇ v`.

    The motion is that of a frame's origin (linear, then angular), or the centroid's: velocity
    of the centre of mass, then angular momentum. The error e is a difference of positions, the
    logarithm of a rotation, or a difference of momenta.

    Attributes:
        components: indices of the controlled components among the six.
    """

    components: ClassVar[slice]

    def __init__(
        self,
        name: str,
        weight: float | np.ndarray,
        kp: float | np.ndarray,
        kd: float | np.ndarray | None,
        priority: int,
    ) -> None:
        size = self.components.stop - self.components.start
        super().__init__(name, size, weight, kp, kd, priority)
        self._frame_id = CENTROID
        self._reference = TaskReference(np.eye(4), np.zeros(size), np.zeros(size))

    @property
    def frame_id(self) -> int:
        """Index of the frame in the model, once bound; `CENTROID` for the centroid."""
        return self._frame_id

    @abstractmethod
    def write_reference(self, kin: Kinematics, reference: TaskReference) -> None:
        """Write the desired pose and motion; a target of None becomes the present pose."""

    def write(self, kin: Kinematics, A: np.ndarray, b: np.ndarray) -> None:
        """See `Task.write`."""
        reference, rows = self._reference, self.components
        self.write_reference(kin, reference)
        at, error = self._error(kin, reference)
        A[:] = at.jacobian[rows]
        np.subtract(reference.acceleration, at.bias[rows], out=b)
        b += self.kd * (reference.velocity - at.velocity[rows])
        b += self.kp * error[rows]

    def write_velocity(
        self, kin: Kinematics, J: np.ndarray, velocity: np.ndarray, error: np.ndarray
    ) -> None:
        """See `Task.write_velocity`."""
        reference, rows = self._reference, self.components
        self.write_reference(kin, reference)
        at, e = self._error(kin, reference)
        J[:] = at.jacobian[rows]
        velocity[:] = reference.velocity
        error[:] = e[rows]

    def _error(
        self, kin: Kinematics, reference: TaskReference
    ) -> tuple[Centroid | FrameKinematics, np.ndarray]:
        """Return the motion that the task is about, and its error e (6,)."""
        error = np.empty(6)
        at: Centroid | FrameKinematics
        if self._frame_id == CENTROID:
            at = kin.centroid
            error[3:] = reference.position - at.velocity[3:]
        else:
            at = kin.motion(self._frame_id)
            error[3:] = pin.log3(reference.rotation @ at.rotation.T)
        error[:3] = reference.position - at.position
        return at, error

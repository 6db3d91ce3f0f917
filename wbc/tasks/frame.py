"""Frame tasks: pose, position or orientation of a frame of the robot."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.errors import TaskError
from wbc.formatting import format_vector
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel
from wbc.tasks.motion import HELD, MotionTask, TaskReference


def is_rotation(R: np.ndarray) -> bool:
    """Return whether a (3, 3) matrix is a rotation (to 1e-6): orthonormal and right-handed."""
    return bool(abs(R @ R.T - np.eye(3)).max() < 1e-6 and np.linalg.det(R) > 0.0)


def format_pose(pose: pin.SE3) -> str:
    """Return position and roll, pitch, yaw of a pose."""
    rotation = format_vector(np.degrees(pin.rpy.matrixToRpy(pose.rotation)), "°")
    return f"{format_vector(pose.translation, 'm')}, roll pitch yaw {rotation}"


class _FrameTask(MotionTask):
    """Base of the three frame tasks: the frame and its desired motion."""

    def __init__(
        self,
        frame: str,
        weight: float | np.ndarray,
        kp: float | np.ndarray,
        kd: float | np.ndarray | None,
        priority: int,
        name: str,
    ) -> None:
        super().__init__(name, weight, kp, kd, priority)
        self.frame = frame
        self.velocity = np.zeros(self.size)
        self.acceleration = np.zeros(self.size)

    def bind(self, robot: RobotModel) -> None:
        """See `Task.bind`."""
        self._frame_id = robot.frame_id(self.frame)

    def _write_motion(self, reference: TaskReference) -> None:
        reference.velocity[:] = self.velocity
        reference.acceleration[:] = self.acceleration


class FrameTask(_FrameTask):
    """Track the pose of a frame.

    `J v̇ = a_ref + kd (v_ref − v) + kp e − J̇ v` with
    `e = [p_ref − p, log(R_ref Rᵀ)]`, the frame's origin in world axes.

    Attributes:
        frame: name of the frame.
        target: desired `T_world_frame`; None: held where first evaluated.
        velocity: (6,) reference velocity, m/s and rad/s, world axes.
        acceleration: (6,) feed-forward, m/s² and rad/s².

    Raises:
        TaskError: the target is no `pin.SE3`, or see `Task`.
    """

    unit = "m/s², rad/s²"
    components = slice(0, 6)

    def __init__(
        self,
        frame: str,
        target: pin.SE3 | None = None,
        *,
        weight: float | np.ndarray = 100.0,
        kp: float | np.ndarray = 100.0,
        kd: float | np.ndarray | None = None,
        priority: int = 1,
        name: str = "",
    ) -> None:
        super().__init__(frame, weight, kp, kd, priority, name or f"{frame} pose")
        self.labels = ("x", "y", "z", "roll", "pitch", "yaw")
        if target is not None and not isinstance(target, pin.SE3):
            raise TaskError(
                f"task '{self.name}': target is a {type(target).__name__}, not a pin.SE3"
            )
        self.target = target

    def _format_target(self) -> str:
        if self.target is None:
            return HELD
        return format_pose(self.target)

    def write_reference(self, kin: Kinematics, reference: TaskReference) -> None:
        """See `MotionTask.write_reference`."""
        if self.target is None:
            self.target = kin.frame(self._frame_id).copy()
        reference.pose[:] = self.target.homogeneous
        self._write_motion(reference)


class PositionTask(_FrameTask):
    """Track the position of a frame's origin: the linear rows of `FrameTask`.

    Attributes:
        target: (3,) m, world; None: held where first evaluated.
        velocity: (3,) m/s.
        acceleration: (3,) m/s².

    Raises:
        TaskError: a target of the wrong shape, or see `Task`.
    """

    unit = "m/s²"
    components = slice(0, 3)

    def __init__(
        self,
        frame: str,
        target: np.ndarray | tuple[float, float, float] | None = None,
        *,
        weight: float | np.ndarray = 100.0,
        kp: float | np.ndarray = 100.0,
        kd: float | np.ndarray | None = None,
        priority: int = 1,
        name: str = "",
    ) -> None:
        super().__init__(frame, weight, kp, kd, priority, name or f"{frame} position")
        self.labels = ("x", "y", "z")
        self.target = None if target is None else self._vector("target", target, 3)

    def _format_target(self) -> str:
        return HELD if self.target is None else format_vector(self.target, "m")

    def write_reference(self, kin: Kinematics, reference: TaskReference) -> None:
        """See `MotionTask.write_reference`."""
        if self.target is None:
            self.target = kin.frame(self._frame_id).translation.copy()
        reference.position[:] = self.target
        self._write_motion(reference)


class OrientationTask(_FrameTask):
    """Track the orientation of a frame: the angular rows of `FrameTask`.

    Attributes:
        target: (3, 3) rotation matrix `R_world_frame`; None: held where first evaluated.
        velocity: (3,) rad/s, world axes.
        acceleration: (3,) rad/s².

    Raises:
        TaskError: the target is no rotation matrix, or see `Task`.
    """

    unit = "rad/s²"
    components = slice(3, 6)

    def __init__(
        self,
        frame: str,
        target: np.ndarray | None = None,
        *,
        weight: float | np.ndarray = 20.0,
        kp: float | np.ndarray = 100.0,
        kd: float | np.ndarray | None = None,
        priority: int = 1,
        name: str = "",
    ) -> None:
        super().__init__(frame, weight, kp, kd, priority, name or f"{frame} orientation")
        self.labels = ("roll", "pitch", "yaw")
        if target is not None:
            target = np.array(target, dtype=float)
            if target.shape != (3, 3) or not is_rotation(target):
                raise TaskError(f"task '{self.name}': target is not a (3, 3) rotation matrix")
        self.target = target

    def _format_target(self) -> str:
        if self.target is None:
            return HELD
        rotation = np.degrees(pin.rpy.matrixToRpy(self.target))
        return f"roll pitch yaw {format_vector(rotation, '°')}"

    def write_reference(self, kin: Kinematics, reference: TaskReference) -> None:
        """See `MotionTask.write_reference`."""
        if self.target is None:
            self.target = kin.frame(self._frame_id).rotation.copy()
        reference.rotation[:] = self.target
        self._write_motion(reference)

"""Pose of a frame as seen from another frame of the robot."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.errors import TaskError
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel
from wbc.tasks.frame import format_pose
from wbc.tasks.function import FunctionRows, FunctionTask
from wbc.tasks.motion import HELD


class RelativeFrameTask(FunctionTask):
    """Track the pose of a frame in the axes of another frame, e.g. of one hand in the other.

    With origins p, p_r, rotations R, R_r, d = p − p_r and twists (v, ω), (v_r, ω_r) in world
    axes, the motion seen from the reference is

        ṗ_rel = R_rᵀ (v − v_r − ω_r × d),   ω_rel = R_rᵀ (ω − ω_r)

    and the error `[p_target − p_rel, log(R_target R_relᵀ)]`, in the axes of the reference. Rows of
    weight 0 are left open.

    Args:
        frame: name of the frame.
        reference: name of the frame from which it is seen.
        target: desired `T_reference_frame`; None: held where first evaluated.

    Attributes:
        frame, reference: as given.
        target: desired `T_reference_frame`; None: held where first evaluated.
        velocity: (6,) reference velocity, m/s and rad/s, axes of the reference.
        acceleration: (6,) feed-forward, m/s² and rad/s².

    Raises:
        TaskError: the target is no `pin.SE3`, both frames are the same, or see `Task`.
    """

    unit = "m/s², rad/s²"

    def __init__(
        self,
        frame: str,
        reference: str,
        target: pin.SE3 | None = None,
        *,
        weight: float | np.ndarray = 100.0,
        kp: float | np.ndarray = 100.0,
        kd: float | np.ndarray | None = None,
        priority: int = 1,
        name: str = "",
    ) -> None:
        super().__init__(name or f"{frame} from {reference}", 6, weight, kp, kd, priority)
        self.labels = ("x", "y", "z", "roll", "pitch", "yaw")
        if frame == reference:
            raise TaskError(f"task '{self.name}': frame and reference are both '{frame}'")
        if target is not None and not isinstance(target, pin.SE3):
            raise TaskError(
                f"task '{self.name}': target is a {type(target).__name__}, not a pin.SE3"
            )
        self.frame, self.reference, self.target = frame, reference, target

    def bind(self, robot: RobotModel) -> None:
        """See `Task.bind`."""
        self._frame_id = robot.frame_id(self.frame)
        self._reference_id = robot.frame_id(self.reference)

    def _format_target(self) -> str:
        return HELD if self.target is None else format_pose(self.target)

    def write_function(self, kin: Kinematics, rows: FunctionRows) -> None:
        """See `FunctionTask.write_function`."""
        at, seen_from = kin.motion(self._frame_id), kin.motion(self._reference_id)
        to_reference = seen_from.rotation.T
        d = at.position - seen_from.position
        if self.target is None:
            self.target = seen_from.placement.actInv(at.placement)
        lever = pin.skew(d)
        J = at.jacobian - seen_from.jacobian
        J[:3] += lever @ seen_from.jacobian[3:]
        rows.J[:3], rows.J[3:] = to_reference @ J[:3], to_reference @ J[3:]
        turn = seen_from.velocity[3:]
        rate = at.velocity - seen_from.velocity
        bias = at.bias - seen_from.bias
        bias[:3] += lever @ seen_from.bias[3:] + np.cross(turn, np.cross(turn, d) - 2.0 * rate[:3])
        bias[3:] -= np.cross(turn, rate[3:])
        rows.bias[:3], rows.bias[3:] = to_reference @ bias[:3], to_reference @ bias[3:]
        rows.error[:3] = self.target.translation - to_reference @ d
        relative = to_reference @ at.rotation
        rows.error[3:] = pin.log3(self.target.rotation @ relative.T)

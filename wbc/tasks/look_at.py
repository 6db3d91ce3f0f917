"""Point an axis of a frame at a place: a camera, a torch, a tool."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from wbc.errors import TaskError
from wbc.formatting import format_vector
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel
from wbc.tasks.function import FunctionRows, FunctionTask

_NEAREST = 1e-3  # m: nearer than that the direction to the target is undefined
_FARTHEST = 1e-4  # of 1 + cos θ: where the target is straight behind
_SMALL = 0.05  # rad: series of θ / sin θ below


class LookAtTask(FunctionTask):
    """Turn a frame until an axis of it points at a place.

    With s the unit vector to the target and a the axis, both in the axes of the frame,
    cos θ = a·s, the function is the rotation that is missing,

        y = (θ / sin θ) (a × s),

    of which the two components across a count; the target is y = 0. It is smooth but for a target
    straight behind (Siciliano et al., Robotics: Modelling, Planning and Control, 2009, §3.7, for
    the error of an orientation).

    Args:
        frame: name of the frame.
        target: (3,) place to look at, world, m.
        axis: (3,) axis in the frame that is to point there, of any length.

    Attributes:
        frame: as given.
        axis: (3,) unit vector.
        target: (3,) m; it may move, at a speed that counts as zero.

    Raises:
        TaskError: a target of the wrong shape, an axis of length zero, or see `Task`.
    """

    unit = "rad/s²"

    def __init__(
        self,
        frame: str,
        target: np.ndarray | tuple[float, float, float],
        *,
        axis: np.ndarray | tuple[float, float, float] = (1.0, 0.0, 0.0),
        weight: float | np.ndarray = 20.0,
        kp: float | np.ndarray = 100.0,
        kd: float | np.ndarray | None = None,
        priority: int = 1,
        name: str = "",
    ) -> None:
        super().__init__(name or f"{frame} looks at", 2, weight, kp, kd, priority)
        self.frame = frame
        self.target = self._vector("target", target, 3)
        axis = self._vector("axis", axis, 3)
        length = float(np.linalg.norm(axis))
        if not length > 0.0:
            raise TaskError(f"task '{self.name}': axis {axis} has no direction")
        self.axis = axis / length
        across = np.eye(3)[int(np.argmin(np.abs(self.axis)))]
        first = np.cross(self.axis, across)
        first /= np.linalg.norm(first)
        self._across = np.array([first, np.cross(self.axis, first)])

    def bind(self, robot: RobotModel) -> None:
        """See `Task.bind`."""
        self._frame_id = robot.frame_id(self.frame)

    def _format_target(self) -> str:
        return format_vector(self.target, "m")

    def write_function(self, kin: Kinematics, rows: FunctionRows) -> None:
        """See `FunctionTask.write_function`."""
        at = kin.motion_local(self._frame_id)
        r = at.rotation.T @ (self.target - at.position)
        distance = max(float(np.linalg.norm(r)), _NEAREST)
        s = r / distance
        turn = at.velocity[3:]
        J = pin.skew(r) @ at.jacobian[3:] - at.jacobian[:3]
        rate = -at.velocity[:3] - np.cross(turn, r)
        bias = -at.bias[:3] - np.cross(at.bias[3:], r) - np.cross(turn, 2.0 * rate)
        bias -= np.cross(turn, np.cross(turn, r))
        # The unit vector s = r/|r|.
        across = (np.eye(3) - np.outer(s, s)) / distance
        approach = float(s @ rate)
        s_rate = across @ rate
        s_bias = across @ bias - s * float(s_rate @ s_rate) - 2.0 * approach / distance * s_rate
        # y = f(c) U (a × s) with c = a·s and f = θ/sin θ.
        c = float(self.axis @ s)
        f, f1, f2 = _angle_over_sine(c)
        z = self._across @ np.cross(self.axis, s)
        z_of_s = self._across @ pin.skew(self.axis)
        c_rate, z_rate = float(self.axis @ s_rate), z_of_s @ s_rate
        y_of_s = f * z_of_s + f1 * np.outer(z, self.axis)
        rows.J[:] = (y_of_s @ across) @ J
        rows.bias[:] = y_of_s @ s_bias + (2.0 * f1 * c_rate) * z_rate + (f2 * c_rate**2) * z
        rows.error[:] = -f * z
        if c < _FARTHEST - 1.0 and not rows.error.any():  # straight behind: any way round
            rows.error[0] = math.pi


def _angle_over_sine(c: float) -> tuple[float, float, float]:
    """Return f = θ/sin θ for cos θ = c, and its first and second derivative in c."""
    c = min(max(c, _FARTHEST - 1.0), 1.0)
    x = 1.0 - c
    if x < 0.5 * _SMALL * _SMALL:  # f = 1 + x/3 + 2 x²/15 + 2 x³/35 + …
        f = 1.0 + x * (1.0 / 3.0 + x * (2.0 / 15.0 + x * 2.0 / 35.0))
        return f, -(1.0 / 3.0 + x * (4.0 / 15.0 + x * 6.0 / 35.0)), 4.0 / 15.0 + x * 12.0 / 35.0
    sine2 = 1.0 - c * c
    f = math.acos(c) / math.sqrt(sine2)
    f1 = (c * f - 1.0) / sine2
    return f, f1, (f + 3.0 * c * f1) / sine2

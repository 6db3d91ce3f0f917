"""Distance of a limb from its singular postures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
import pinocchio as pin

from wbc.errors import TaskError
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel
from wbc.tasks.function import FunctionRows, FunctionTask

_ROWS = {"pose": slice(0, 6), "position": slice(0, 3), "orientation": slice(3, 6)}
_FLOOR = 1e-6  # m², rad²: keeps the logarithm finite in a singular posture
_STEP = 1e-5  # s: half the interval of the derivative along the motion


class ManipulabilityTask(FunctionTask):
    """Keep the manipulability of a limb from falling below a value.

    For the Jacobian J of a frame over the joints of its limb, the manipulability is the volume of
    the ellipsoid of velocities that unit joint velocities reach, `w = √det(J Jᵀ)` (Yoshikawa,
    Manipulability of robotic mechanisms, International Journal of Robotics Research 1985). The
    function is its logarithm, `y = ½ ln det(J Jᵀ + 1e-6 I)`, with

        ∂y/∂q_k = tr((J Jᵀ + 1e-6 I)⁻¹ (∂J/∂q_k) Jᵀ).

    The task asks for nothing, with a row of zeros, while w is above the target.

    Args:
        robot: the robot.
        frame: name of the frame.
        target: manipulability w, in the units of the chosen rows.
        rows: "position" (m³), "orientation" or "pose" (m³): which rows of J count.
        joints: names of the joints of the limb; those between base and frame when left out.

    Attributes:
        frame: as given.
        target: w.

    Raises:
        FrameNotFound: the frame is missing.
        JointNotFound: one of the joints is missing.
        TaskError: fewer joints than rows, a target that is not positive, or see `Task`.
    """

    unit = "1/s²"

    def __init__(
        self,
        robot: RobotModel,
        frame: str,
        target: float,
        *,
        rows: Literal["position", "orientation", "pose"] = "position",
        joints: Sequence[str] | None = None,
        weight: float | np.ndarray = 1.0,
        kp: float | np.ndarray = 25.0,
        kd: float | np.ndarray | None = None,
        priority: int = 1,
        name: str = "",
    ) -> None:
        super().__init__(name or f"{frame} manipulability", 1, weight, kp, kd, priority)
        if not 0.0 < target < math.inf:
            raise TaskError(f"task '{self.name}': target {target} must be positive and finite")
        if rows not in _ROWS:
            raise TaskError(f"task '{self.name}': rows '{rows}' must be one of {', '.join(_ROWS)}")
        self.frame, self.target = frame, float(target)
        self._rows = _ROWS[rows]
        model = robot.model
        self._frame_id = robot.frame_id(frame)
        chain = [int(j) for j in model.supports[model.frames[self._frame_id].parentJoint] if j > 1]
        if joints is not None:
            wanted = {robot.joint_index(joint) + 2 for joint in joints}
            chain = [joint for joint in chain if joint in wanted]
        self._dofs = np.array([joint + 4 for joint in chain], dtype=int)
        size = self._rows.stop - self._rows.start
        if len(chain) < size:
            raise TaskError(
                f"task '{self.name}': {len(chain)} joints move the frame, fewer than its {size} "
                f"rows: its manipulability is always zero; choose other rows than '{rows}'"
            )
        self._model, self._data = model, model.createData()

    def __getstate__(self) -> dict[str, object]:
        """Return everything but Pinocchio's workspace."""
        return {k: v for k, v in self.__dict__.items() if k != "_data"}

    def __setstate__(self, state: dict[str, object]) -> None:
        super().__setstate__(state)
        self._data = self._model.createData()

    def _format_target(self) -> str:
        return f"{self.target:g}"

    def manipulability(self, q: np.ndarray) -> float:
        """Return w in a configuration (nq,)."""
        J = self._jacobian(q)[self._rows]
        return math.sqrt(max(float(np.linalg.det(J @ J.T)), 0.0))

    def write_function(self, kin: Kinematics, rows: FunctionRows) -> None:
        """See `FunctionTask.write_function`."""
        q, v = kin.state.q, kin.state.v
        value, gradient = self._value_and_gradient(q)
        rows.J[:] = 0.0
        rows.bias[0] = 0.0
        rows.error[0] = max(math.log(self.target) - value, 0.0)
        if not rows.error[0]:
            return
        rows.J[0, self._dofs] = gradient
        rate = v[self._dofs]
        if rate.any():
            ahead, behind = q.copy(), q.copy()
            ahead[self._dofs + 1] += _STEP * rate
            behind[self._dofs + 1] -= _STEP * rate
            change = self._value_and_gradient(ahead)[1] - self._value_and_gradient(behind)[1]
            rows.bias[0] = change @ rate / (2.0 * _STEP)

    def _jacobian(self, q: np.ndarray) -> np.ndarray:
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        J = pin.computeFrameJacobian(self._model, self._data, q, self._frame_id, axes)
        return np.asarray(J)[:, self._dofs]

    def _value_and_gradient(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Return y and its gradient over the joints of the limb.

        A joint k turns all columns of later joints with it, and moves the frame's origin, by which
        the linear part of an earlier column i changes by z_i × J_k.
        """
        J = self._jacobian(q)
        linear, angular = J[:3].T, J[3:].T
        n = len(linear)
        # Derivative of column i (second index) by joint k (first index).
        later = np.arange(n)[None, :, None] >= np.arange(n)[:, None, None]
        turned = np.where(later, angular[:, None], 0.0)
        by_joint = np.empty((n, n, 6))
        by_joint[:, :, :3] = np.cross(turned, linear[None])
        by_joint[:, :, :3] += np.where(later, 0.0, np.cross(angular[None], linear[:, None]))
        by_joint[:, :, 3:] = np.cross(turned, angular[None])
        part = J[self._rows]
        square = part @ part.T + _FLOOR * np.eye(len(part))
        sign_and_log = np.linalg.slogdet(square)
        G = np.linalg.solve(square, part)  # (m, n)
        gradient = np.einsum("mi,kim->k", G, by_joint[:, :, self._rows])
        return 0.5 * float(sign_and_log[1]), gradient

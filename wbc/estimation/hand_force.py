"""The force on a hand, from the torques of the joints of its arm."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from wbc.errors import MeasurementError
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel

_DAMPING = 0.02  # m, of the least squares near singular postures


class HandForceEstimator:
    """Observes the external force on a hand without a force sensor.

    The joints of the arm have the generalised momentum p = (M v)_arm. What changes it beside the
    motors' torques τ and the bias forces h is the external force F on the hand,

        r = (p − ∫ (τ − h + r) dt) / T,    r ≈ Jᵀ F,

    a low-pass of Jᵀ F with time constant T (A. De Luca, R. Mattone, *Sensorless robot collision
    detection and hybrid force/motion control*, ICRA 2005). The term Ṁ v − (C + Cᵀ) v, quadratic in
    the velocities, is left out: hands that press or carry move slowly. F is the damped
    least-squares solution of `Jᵀ F = r`.

    Args:
        robot: the robot.
        dt: period of `update`, s.
        frame: name of the hand's frame.
        joints: indices into (na,) of the arm's joints.
        point: (3,) where the force acts, in the axes of the hand's frame, m; its origin if None.
        time_constant: T, s.

    Attributes:
        force: (3,) estimated force of the environment on the hand, world axes, N.

    Raises:
        MeasurementError: the time constant is not positive, or there are no joints.
        FrameNotFound: the robot has no such frame.
    """

    def __init__(
        self,
        robot: RobotModel,
        dt: float,
        frame: str,
        joints: Sequence[int],
        *,
        point: np.ndarray | None = None,
        time_constant: float = 0.05,
    ) -> None:
        if not (math.isfinite(time_constant) and time_constant > 0.0 and len(joints)):
            raise MeasurementError(
                f"HandForceEstimator: time_constant = {time_constant} s must be positive, and "
                f"joints = {tuple(joints)} at least one"
            )
        self._dt, self._gain = dt, 1.0 / time_constant
        self._frame = robot.frame_id(frame)
        self._point = np.zeros(3) if point is None else np.array(point, dtype=float)
        self._joints = np.array(joints, dtype=int)
        self._rows = 6 + self._joints
        self.reset()

    def reset(self) -> None:
        """Start anew, without a force."""
        self.force = np.zeros(3)
        self._integral: np.ndarray | None = None
        self._residual = np.zeros(self._joints.size)

    def update(self, kin: Kinematics, torque: np.ndarray) -> np.ndarray:
        """Take in a tick; return `force`.

        Args:
            kin: state at the beginning of the tick.
            torque: (na,) torques that the motors exert during it, N·m.
        """
        rows = self._rows
        momentum = kin.mass_matrix[rows] @ kin.state.v
        if self._integral is None:
            self._integral = momentum.copy()
        residual = self._residual = self._gain * (momentum - self._integral)
        self._integral += self._dt * (torque[self._joints] - kin.bias_forces[rows] + residual)
        at = kin.motion(self._frame)
        J = at.jacobian[:3, rows] - pin.skew(at.rotation @ self._point) @ at.jacobian[3:, rows]
        self.force = np.linalg.solve(J @ J.T + _DAMPING**2 * np.eye(3), J @ residual)
        return self.force

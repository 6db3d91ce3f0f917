"""Where the soles and the base are, as seen from the IMU."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.robot import Robot


class Legs:
    """Kinematics between IMU, base and soles.

    Args:
        robot: whose legs these are.

    Attributes:
        T_imu_base: base axes to IMU axes, after `update`.
        relative: twist of the IMU relative to the base, IMU axes; None for an IMU on the
            base link, where it is zero.
    """

    def __init__(self, robot: Robot) -> None:
        self._model = robot.model
        self._data = data = robot.model.createData()
        imu = robot.model.frames[robot.frame_id(robot.imu)]
        # Pinocchio's own memory, looked up once: it shows what the last update computed.
        self._imu_body, self._imu_twist = data.oMi[imu.parentJoint], data.v[imu.parentJoint]
        self._imu_placement: pin.SE3 = imu.placement
        # On the base link, where it mostly is, the IMU needs no kinematics of its own.
        self._fixed: bool = imu.parentJoint == 1
        self.T_imu_base: pin.SE3 = imu.placement.inverse()
        self.relative: pin.Motion | None = None
        self._soles = [(data.oMi[s.joint_id], s.placement) for s in robot.soles]
        self._q = pin.neutral(robot.model)
        self._v = np.zeros(robot.nv)

    def update(self, position: np.ndarray, velocity: np.ndarray) -> None:
        """Take the joints' (na,) positions and velocities, rad and rad/s."""
        self._q[7:] = position
        if self._fixed:
            pin.forwardKinematics(self._model, self._data, self._q)
            return
        self._v[6:] = velocity
        pin.forwardKinematics(self._model, self._data, self._q, self._v)
        self.T_imu_base = (self._imu_body * self._imu_placement).inverse()
        self.relative = self._imu_placement.actInv(self._imu_twist)

    def sole(self, index: int) -> pin.SE3:
        """Sole axes to IMU axes."""
        body, placement = self._soles[index]
        return self.T_imu_base * body * placement

    def sole_height(self, index: int, up: np.ndarray) -> float:
        """How far a sole is along `up`, (3,) in IMU axes, from the IMU, m."""
        return float(up @ self.sole(index).translation)


def leg_covariance(robot: Robot, index: int, encoder: float) -> np.ndarray:
    """(6, 6) of a sole's pose as the encoders see it from the IMU, at the nominal posture.

    `C = σ² J Jᵀ` with the Jacobian of the sole relative to the IMU; position, then
    rotation vector, IMU axes; m, rad.

    Args:
        robot: the robot.
        index: of the sole.
        encoder: σ, rad.
    """
    model, sole = robot.model, robot.soles[index]
    data = model.createData()
    q = np.array(robot.q_nominal)
    q[:7] = pin.neutral(model)[:7]
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    imu = robot.frame_id(robot.imu)
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    J = pin.getFrameJacobian(model, data, sole.frame_id, axes)[:, 6:]
    J_imu = pin.getFrameJacobian(model, data, imu, axes)[:, 6:]
    lever = data.oMf[sole.frame_id].translation - data.oMf[imu].translation
    J = J - J_imu
    J[:3] += pin.skew(lever) @ J_imu[3:]
    R = data.oMf[imu].rotation.T
    J = np.vstack([R @ J[:3], R @ J[3:]])
    # A leg of fewer than six joints alone would make the filter singular.
    C: np.ndarray = encoder**2 * (J @ J.T) + 1e-8 * np.eye(6)
    return C

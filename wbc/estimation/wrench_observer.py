"""Wrenches of the ground on the soles, observed from joint torques and IMU."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pinocchio as pin

from wbc.errors import MeasurementError
from wbc.estimation.kernels.wrenches import solve_wrenches
from wbc.measurement import Measurement
from wbc.robot import Robot

_LOCAL = pin.ReferenceFrame.LOCAL
_SMOOTHING = 0.008  # s, time constant of the low-pass
_TORQUE = 0.03  # error of a joint's torque, mostly friction: a share of its limit


class WrenchObserver:
    """Contact wrenches of a robot without foot sensors.

    What gravity, inertia and the motors' torques leave of the equation of motion,

        r = M v̇ + h − Sᵀ τ = Σ Jᵢᵀ Fᵢ,

    is what the ground exerts on the soles. The wrenches are the weighted least squares of all
    rows: those of the base have only the IMU's error, and that of masses; those of the joints have
    the friction, which no motor's current tells from a load. Specific force and rates of
    the IMU take the place of the base's acceleration and gravity, so that neither attitude nor
    velocity of the base is needed. Torques and specific force pass a low-pass of 8 ms, and the
    accelerations of the joints are the rate of their low-passed velocities: to first order the
    generalised-momentum observer of De Luca et al., *Collision detection and safe reaction with the
    DLR-III lightweight manipulator arm*, IROS 2006.

    Args:
        robot: the robot.
        dt: period of `update`, s.
        force_error: error of the whole robot's force, as a share of its weight: of the masses and
            the IMU, or what else than the ground may carry the robot.
        moment_error: error of the whole robot's moment, as a lever of its weight, m.
    """

    def __init__(
        self, robot: Robot, dt: float, *, force_error: float = 0.02, moment_error: float = 0.03
    ) -> None:
        self._robot, model = robot, robot.model
        self._gravity = np.array(model.gravity.linear)
        self._data = model.createData()
        self._imu = robot.frame_id(robot.imu)
        self._imu_on_base = model.frames[self._imu].parentJoint == 1
        self._soles = [(sole.name, robot.frame_id(sole.name)) for sole in robot.soles]
        force, moment = force_error * robot.weight, moment_error * robot.weight
        deviation = np.concatenate(([force] * 3, [moment] * 3, _TORQUE * np.array(robot.tau_max)))
        self._weight = 1.0 / np.square(deviation)
        self._dt, self._share = dt, min(dt / _SMOOTHING, 1.0)
        self._q = pin.neutral(model)
        self._v, self._a = np.zeros((2, robot.nv))
        size = 6 * len(self._soles)
        self._J = np.zeros((size, robot.nv))
        self._work = np.zeros((size, size))
        self.reset()

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_data"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._data = self._robot.model.createData()

    def reset(self) -> None:
        """Start anew, from the next measurement."""
        self._velocity: np.ndarray | None = None  # low-passed [base's rates, joints'], rad/s
        self._force = np.zeros(0)  # low-passed [specific force, torques], m/s² and N·m

    def update(self, m: Measurement, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """Take in a measurement with joint torques; return the wrench on each sole.

        Args:
            m: IMU and joint torques.
            q: (na,) joint positions, smoothed, rad.
            v: (na,) joint velocities, smoothed, rad/s.

        Returns:
            Sole name -> (6,) force then moment at the sole's centre, in sole axes; N, N·m.

        Raises:
            MeasurementError: torques of a wrong size or not finite.
        """
        tau = m.joint_torque
        if tau is None or tau.shape != q.shape or not math.isfinite(tau.dot(tau)):
            raise MeasurementError(
                f"measurement.joint_torque is {tau!r}: it must be {q.size} finite numbers, N·m"
            )
        self._q[7:], self._v[6:] = q, v
        self._move(m, tau)
        model, data, J = self._robot.model, self._data, self._J
        residual = pin.rnea(model, data, self._q, self._v, self._a)
        residual[6:] -= self._force[3:]
        pin.computeJointJacobians(model, data, self._q)
        for i, (_, frame) in enumerate(self._soles):
            J[6 * i : 6 * i + 6] = pin.getFrameJacobian(model, data, frame, _LOCAL)
        wrenches = np.empty(J.shape[0])
        solve_wrenches(J, residual, self._weight, wrenches, self._work)
        return {name: wrenches[6 * i : 6 * i + 6] for i, (name, _) in enumerate(self._soles)}

    def _move(self, m: Measurement, tau: np.ndarray) -> None:
        """Write the robot's motion, its base's acceleration minus gravity, in the base's axes."""
        model, data, imu, share = self._robot.model, self._data, self._imu, self._share
        self._v[:6] = self._a[:6] = 0.0
        if not self._imu_on_base:
            pin.forwardKinematics(model, data, self._q, self._v)
        R = pin.updateFramePlacement(model, data, imu).rotation
        rates = m.gyro
        if not self._imu_on_base:
            rates = rates - pin.getFrameVelocity(model, data, imu, _LOCAL).angular
        self._v[3:6] = R @ rates
        velocity, force = self._v[3:], np.concatenate((m.accelerometer, tau))
        if self._velocity is None:
            self._velocity, self._force = velocity.copy(), force
        change = share * (velocity - self._velocity)
        self._velocity += change
        self._force += share * (force - self._force)
        np.divide(change, self._dt, out=self._a[3:])
        pin.forwardKinematics(model, data, self._q, self._v, self._a)
        moving = pin.getFrameClassicalAcceleration(model, data, imu, _LOCAL).linear
        # Base axes are the world's here, so that the gravity which `rnea` adds drops out.
        self._a[:3] = R @ (self._force[:3] - moving) + self._gravity

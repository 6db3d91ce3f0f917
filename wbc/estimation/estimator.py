"""From sensor readings to the state of the whole robot."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np
import pinocchio as pin

from wbc.errors import ContactError, MeasurementError
from wbc.estimation import so3
from wbc.estimation.contact import ContactTrigger
from wbc.estimation.inekf import InvariantFilter
from wbc.estimation.joints import JointFilter
from wbc.estimation.noise import EstimatorNoise
from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.state import State

#: Without foot sensors, soles within this of the lowest one are taken to stand, m.
_LEVEL = 0.005


class Estimator:
    """State of a walking robot from encoders, IMU and foot forces.

    The base comes from an `InvariantFilter` at the IMU's frame, corrected by the soles
    that stand; the joints from a `JointFilter`. Neither the heading nor the place on the
    ground is measured by any sensor: both start from `reset` and drift slowly, by
    touchdowns and slip. Only what a real robot measures is read; the exact state of a
    simulator goes through `GroundTruthEstimator`.

    Which soles stand is told from the foot forces by `trigger`. Without foot forces it
    is what `contacts` says, and without that the soles that the estimate places lowest:
    good for standing and slow walking on flat floor, not for running or stairs.

    Args:
        robot: its model gives the kinematics; the IMU is at the frame `robot.imu`.
        dt: period of `update`, s.
        noise: what is assumed of sensors and feet.
        trigger: decides on contacts.
        joint_acceleration: how hard a joint is believed to accelerate unforeseen,
            rad/s²: the bandwidth of the joint filter; infinity switches it off. Measured
            on a walking Talos: 25 leaves 0.034 rad/s of the velocity readings' 0.05, 12
            leaves 0.028, 6 leaves 0.036 by its lag, and 0.017 when `update` is given the
            commanded acceleration.
        correct_every: periods between two corrections by the legs. The joint filter hands
            the encoders' readings on across them, so little is lost.
    """

    def __init__(
        self,
        robot: Robot,
        dt: float = 0.002,
        *,
        noise: EstimatorNoise | None = None,
        trigger: ContactTrigger | None = None,
        joint_acceleration: float = 10.0,
        correct_every: int = 2,
    ) -> None:
        self.robot = robot
        self.dt = dt
        self._noise = EstimatorNoise() if noise is None else noise
        self._trigger = ContactTrigger() if trigger is None else trigger
        self._model = robot.model
        self._data = robot.model.createData()
        gravity = np.array(robot.model.gravity.linear)
        self._weight = float(robot.mass * np.linalg.norm(gravity))
        self.filter = InvariantFilter(
            len(robot.soles),
            dt,
            gravity,
            self._noise,
            [_leg_covariance(robot, i, self._noise.encoder) for i in range(len(robot.soles))],
            every=correct_every,
        )
        self._joints = JointFilter(
            robot.na, dt, self._noise.encoder, self._noise.joint_velocity, joint_acceleration
        )
        imu = robot.model.frames[robot.frame_id(robot.imu)]
        self._imu_joint: int = imu.parentJoint
        self._imu_placement: pin.SE3 = imu.placement
        # On the base link, where it mostly is, the IMU needs no kinematics of its own.
        self._imu_fixed = self._imu_joint == 1
        self._imu_inverse: pin.SE3 = imu.placement.inverse()
        self._soles = [(s.name, s.joint_id, s.placement) for s in robot.soles]
        self._joint_shape = (robot.na,)
        self._local = pin.neutral(robot.model)
        self._local_v = np.zeros(robot.nv)
        self.reset(robot.standing())

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the soles that are taken to stand."""
        return tuple(s[0] for s, stands in zip(self._soles, self._stands, strict=True) if stands)

    def reset(self, state: State) -> None:
        """Start at a state whose place, heading and posture are taken as true.

        Roll, pitch and velocity may be off by what `noise` says; biases are unknown.

        Raises:
            StateError: wrong sizes, NaN or a quaternion that is not of unit length.
        """
        state = state.checked(self._model)
        self._local[7:] = state.q[7:]
        self._local_v[6:] = state.v[6:]
        pin.forwardKinematics(self._model, self._data, self._local, self._local_v)
        T_base_imu = self._T_base_imu()
        base = pin.SE3(pin.Quaternion(state.q[3:7]).toRotationMatrix(), state.q[:3])
        world = base * T_base_imu
        twist = T_base_imu.actInv(pin.Motion(state.v[:6])) + self._imu_relative_velocity()
        self.filter.reset(world.rotation, world.rotation @ twist.linear)
        self._origin = np.array(world.translation)
        self._joints.reset()
        self._stands = [False] * len(self._soles)
        self._gyro: np.ndarray | None = None
        self._time = 0.0

    def update(
        self,
        measurement: Measurement,
        contacts: Collection[str] | None = None,
        acceleration: np.ndarray | None = None,
    ) -> State:
        """The state at the time of a measurement.

        The first measurement after a reset belongs to the reset's instant; each next one
        comes a period later.

        Args:
            measurement: what the sensors read; its `ground_truth` is not looked at.
            contacts: names of the soles that stand, instead of asking the foot forces.

            acceleration: (nv,) what the last command was to bring about
                (`Command.acceleration`); takes the lag out of the joint filter.

        Returns:
            State with new arrays: base pose in the world, base twist in the base frame,
            filtered joints.

        Raises:
            MeasurementError: a wrong size or a reading that is not finite.
            ContactError: an unknown sole in `contacts`.
        """
        self._check(measurement)
        filter_ = self.filter
        shares = self._shares(measurement)
        gyro = np.asarray(measurement.gyro, dtype=float)
        due = False
        if self._gyro is not None:
            slip = [
                self._trigger.slip_factor(share) if stands else 0.0
                for share, stands in zip(shares, self._stands, strict=True)
            ]
            due = filter_.propagate(0.5 * (gyro + self._gyro), measurement.accelerometer, slip)
        self._gyro = gyro
        position, velocity = self._joints.update(
            measurement.joint_position,
            measurement.joint_velocity,
            None if acceleration is None else acceleration[6:],
        )
        self._local[7:] = position
        if self._imu_fixed:
            pin.forwardKinematics(self._model, self._data, self._local)
        else:
            self._local_v[6:] = velocity
            pin.forwardKinematics(self._model, self._data, self._local, self._local_v)
        T_base_imu = self._T_base_imu()
        T_imu_base = self._imu_inverse if self._imu_fixed else T_base_imu.inverse()
        legs = [T_imu_base * self._data.oMi[j] * placement for _, j, placement in self._soles]
        stands = self._decide(measurement, shares, contacts, legs)
        self._correct(stands, legs, due)
        return self._state(T_imu_base, gyro, position, velocity)

    def _check(self, measurement: Measurement) -> None:
        q, v = measurement.joint_position, measurement.joint_velocity
        gyro, accelerometer = measurement.gyro, measurement.accelerometer
        # One sum is finite only if every reading is; what is wrong is found out after.
        if (
            q.shape == self._joint_shape
            and v.shape == self._joint_shape
            and gyro.shape == (3,)
            and accelerometer.shape == (3,)
            and math.isfinite(q.sum() + v.sum() + gyro.sum() + accelerometer.sum())
        ):
            return
        for name, shape in (
            ("joint_position", self._joint_shape),
            ("joint_velocity", self._joint_shape),
            ("gyro", (3,)),
            ("accelerometer", (3,)),
        ):
            reading = getattr(measurement, name)
            if reading.shape != shape:
                raise MeasurementError(
                    f"measurement.{name} has shape {reading.shape}, the robot needs {shape}"
                )
            if not np.isfinite(reading).all():
                raise MeasurementError(f"measurement.{name} has entries that are not finite")

    def _shares(self, measurement: Measurement) -> list[float]:
        """Normal force of each sole over the weight; equal shares without sensors."""
        wrenches = measurement.foot_wrenches
        if not wrenches:
            return [1.0 / len(self._soles)] * len(self._soles)
        shares = []
        for name, _, _ in self._soles:
            wrench = wrenches.get(name)
            if wrench is None or np.shape(wrench) != (6,) or not np.isfinite(wrench.sum()):
                raise MeasurementError(
                    f"measurement.foot_wrenches['{name}'] is {wrench!r}: it needs six finite "
                    "numbers for every sole, or no entries at all without foot sensors"
                )
            shares.append(float(wrench[2]) / self._weight)
        return shares

    def _decide(
        self,
        measurement: Measurement,
        shares: list[float],
        contacts: Collection[str] | None,
        legs: list[pin.SE3],
    ) -> list[bool]:
        """Which soles stand."""
        if contacts is not None:
            names = [s[0] for s in self._soles]
            unknown = [c for c in contacts if c not in names]
            if unknown:
                raise ContactError(f"no sole is called '{unknown[0]}'; there are: {names}")
            return [name in contacts for name in names]
        if measurement.foot_wrenches:
            return [
                self._trigger.stands(share, before)
                for share, before in zip(shares, self._stands, strict=True)
            ]
        up = self.filter.R[2]
        heights = [float(up @ leg.translation) for leg in legs]
        return [height < min(heights) + _LEVEL for height in heights]

    def _correct(self, stands: list[bool], legs: list[pin.SE3], due: bool) -> None:
        """Correct by the soles that stood and stand; take in those that came down."""
        held = tuple(i for i, now in enumerate(stands) if now and self._stands[i])
        if held and due:
            h = np.array([legs[i].translation for i in held])
            F = np.array([legs[i].rotation for i in held])
            self.filter.correct(held, h, F)
        for i, now in enumerate(stands):
            if now and not self._stands[i]:
                self.filter.land(i, legs[i].translation, legs[i].rotation)
        self._stands = stands

    def _state(
        self, T_imu_base: pin.SE3, gyro: np.ndarray, position: np.ndarray, velocity: np.ndarray
    ) -> State:
        filter_ = self.filter
        # T_imu_base as plain arrays: Pinocchio's small objects cost more than the products.
        R, p = T_imu_base.rotation, T_imu_base.translation
        q = np.empty(self._model.nq)
        v = np.empty(self._model.nv)
        q[:3] = self._origin + filter_.p + filter_.R @ p
        q[3:7] = so3.quaternion(filter_.R @ R)
        q[7:] = position
        linear = filter_.v @ filter_.R
        angular = gyro - filter_.gyro_bias
        if not self._imu_fixed:
            relative = self._imu_relative_velocity()
            linear -= relative.linear
            angular -= relative.angular
        x, y, z = angular.tolist()
        a, b, c = p.tolist()
        linear += (y * c - z * b, z * a - x * c, x * b - y * a)
        v[:3] = linear @ R
        v[3:6] = angular @ R
        v[6:] = velocity
        return State(q, v)

    def _T_base_imu(self) -> pin.SE3:
        if self._imu_fixed:
            return self._imu_placement
        return self._data.oMi[self._imu_joint] * self._imu_placement

    def _imu_relative_velocity(self) -> pin.Motion:
        """Twist of the IMU relative to the base, IMU axes; needs a first-order kinematics."""
        if self._imu_fixed:
            return pin.Motion.Zero()
        return self._imu_placement.actInv(self._data.v[self._imu_joint])


def _leg_covariance(robot: Robot, index: int, encoder: float) -> np.ndarray:
    """(6, 6) of a sole's pose as encoders see it from the IMU, IMU axes, at the nominal posture.

    `C = σ² J Jᵀ` with the Jacobian of the sole relative to the IMU, position first.
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
    # A model without joints between IMU and sole would make the filter singular.
    C: np.ndarray = encoder**2 * (J @ J.T) + 1e-8 * np.eye(6)
    return C

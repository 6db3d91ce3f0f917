"""From sensor readings to the state of the whole robot."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np
import pinocchio as pin

from wbc.errors import ContactError, MeasurementError
from wbc.estimation.contact import ContactDetector, ContactTrigger
from wbc.estimation.estimate import Estimate
from wbc.estimation.inekf import InvariantFilter
from wbc.estimation.joints import JointFilter
from wbc.estimation.legs import Legs, leg_covariance
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
        joint_acceleration: how hard a joint is believed to accelerate, rad/s²: the
            bandwidth of the joint filter; infinity switches it off. On a walking Talos
            and a walking G1, readings of 0.05 rad/s come out at 0.033 and 0.039 with 20,
            at 0.038 and 0.061 with 10 by lag, at 0.040 and 0.040 with 40.
        joint_surprise: the same for what is left when `update` is given the commanded
            acceleration; that brings 0.019 and 0.022.
        correct_every: periods between two corrections by the legs; touchdowns are taken
            in at once. The joint filter hands the encoders' readings on across them: the
            errors of 1, 2, 4 and 8 differ by less than a tenth.
    """

    def __init__(
        self,
        robot: Robot,
        dt: float = 0.002,
        *,
        noise: EstimatorNoise | None = None,
        trigger: ContactTrigger | None = None,
        joint_acceleration: float = 20.0,
        joint_surprise: float = 6.0,
        correct_every: int = 4,
    ) -> None:
        self.robot = robot
        self.dt = dt
        self._noise = EstimatorNoise() if noise is None else noise
        self._detector = ContactDetector(robot, trigger)
        self._model = robot.model
        self._legs = Legs(robot)
        gravity = np.array(robot.model.gravity.linear)
        self.filter = InvariantFilter(
            len(robot.soles),
            dt,
            gravity,
            self._noise,
            [leg_covariance(robot, i, self._noise.encoder) for i in range(len(robot.soles))],
            every=correct_every,
        )
        self._joints = JointFilter(
            robot.na,
            dt,
            self._noise.encoder,
            self._noise.joint_velocity,
            joint_acceleration,
            joint_surprise,
        )
        self._joint_shape = (robot.na,)
        self._T_world_imu, self._twist = pin.SE3.Identity(), pin.Motion.Zero()
        self.reset(robot.standing())

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the soles that are taken to stand."""
        return self._detector.contacts

    def reset(self, state: State) -> None:
        """Start at a state whose place, heading and posture are taken as true.

        Roll, pitch and velocity may be off by what `noise` says; biases are unknown.

        Raises:
            StateError: wrong sizes, NaN or a quaternion that is not of unit length.
        """
        state = state.validated(self._model)
        legs = self._legs
        legs.update(state.q[7:], state.v[6:])
        base = pin.SE3(pin.Quaternion(state.q[3:7]).toRotationMatrix(), state.q[:3])
        world = base * legs.T_imu_base.inverse()
        twist = legs.T_imu_base.act(pin.Motion(state.v[:6]))
        if legs.relative is not None:
            twist += legs.relative
        self.filter.reset(world.rotation, world.rotation @ twist.linear)
        self._origin = np.array(world.translation)
        self._joints.reset()
        self._detector.reset()
        self._gyro: np.ndarray | None = None

    def update(
        self,
        measurement: Measurement,
        contacts: Collection[str] | None = None,
        acceleration: np.ndarray | None = None,
    ) -> Estimate:
        """Return state, contacts and foot loads at the time of a measurement.

        The first measurement after a reset belongs to the reset's instant; each next one
        comes a period later.

        Args:
            measurement: what the sensors read; its `ground_truth` is not looked at.
            contacts: names of the soles that stand, instead of asking the foot forces.
            acceleration: (nv,) what the last command was to bring about
                (`Command.acceleration`); takes the lag out of the joint filter.

        Returns:
            An estimate whose state has new arrays: base pose in the world, base twist in the
            base frame, filtered joints.

        Raises:
            MeasurementError: a wrong size, a reading that is not finite, or foot wrenches of
                some soles only.
            ContactError: an unknown sole in `contacts`.
        """
        self._check(measurement)
        detector = self._detector
        loads = detector.loads(measurement.foot_wrenches)
        before = detector.stands
        gyro = measurement.gyro
        due = False
        if self._gyro is not None:
            mean = 0.5 * (gyro + self._gyro)
            due = self.filter.propagate(mean, measurement.accelerometer, self._slip(loads))
        self._gyro = gyro
        position, velocity = self._joints.update(
            measurement.joint_position,
            measurement.joint_velocity,
            None if acceleration is None else acceleration[6:],
        )
        self._legs.update(position, velocity)
        if contacts is not None:
            detector.stands = self._told(contacts)
        elif loads is not None:
            detector.update(loads)
        else:
            detector.stands = self._lowest()
        self._correct(before, detector.stands, due)
        return Estimate(
            self._state(gyro, position, velocity),
            detector.contacts,
            loads,
            measurement.foot_wrenches,
        )

    def _check(self, measurement: Measurement) -> None:
        q, v = measurement.joint_position, measurement.joint_velocity
        gyro, accelerometer = measurement.gyro, measurement.accelerometer
        # One sum of squares is finite only if every reading is; what is wrong is told below.
        if (
            q.shape == self._joint_shape
            and v.shape == self._joint_shape
            and gyro.shape == (3,)
            and accelerometer.shape == (3,)
            and math.isfinite(
                q.dot(q) + v.dot(v) + gyro.dot(gyro) + accelerometer.dot(accelerometer)
            )
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

    def _slip(self, loads: Mapping[str, float] | None) -> list[float]:
        """Per sole, a factor on its wandering; 0 in the air, equal loads without sensors."""
        names, trigger = self._detector.names, self._detector.trigger
        equal = 1.0 / len(names)
        return [
            trigger.slip_factor(equal if loads is None else loads[name]) if stands else 0.0
            for name, stands in zip(names, self._detector.stands, strict=True)
        ]

    def _told(self, contacts: Collection[str]) -> list[bool]:
        names = self._detector.names
        unknown = [c for c in contacts if c not in names]
        if unknown:
            raise ContactError(f"no sole is called '{unknown[0]}'; there are: {list(names)}")
        return [name in contacts for name in names]

    def _lowest(self) -> list[bool]:
        up = self.filter.R[2]
        heights = [self._legs.sole_height(i, up) for i in range(len(self._detector.names))]
        return [height < min(heights) + _LEVEL for height in heights]

    def _correct(self, before: list[bool], stands: list[bool], due: bool) -> None:
        """Correct by the soles that stood and stand; take in those that came down."""
        if due:
            held = tuple(i for i, now in enumerate(stands) if now and before[i])
            if held:
                legs = [self._legs.sole(i) for i in held]
                h = np.array([leg.translation for leg in legs])
                F = np.array([leg.rotation for leg in legs])
                self.filter.correct(held, h, F)
        if stands != before:
            for i, now in enumerate(stands):
                if now and not before[i]:
                    leg = self._legs.sole(i)
                    self.filter.land(i, leg.translation, leg.rotation)

    def _state(self, gyro: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> State:
        velocity_imu, place = self.filter.vectors[:2]
        R_imu, T_imu_base = self.filter.R, self._legs.T_imu_base
        q = np.empty(self._model.nq)
        v = np.empty(self._model.nv)
        T_world_imu, twist = self._T_world_imu, self._twist
        T_world_imu.rotation = R_imu
        T_world_imu.translation = self._origin + place
        q[:7] = pin.SE3ToXYZQUAT(T_world_imu * T_imu_base)
        if q[6] < 0.0:
            q[3:7] *= -1.0
        q[7:] = position
        twist.linear = velocity_imu.dot(R_imu)
        twist.angular = gyro - self.filter.gyro_bias
        relative = self._legs.relative
        if relative is not None:
            twist -= relative
        v[:6] = T_imu_base.actInv(twist).vector
        v[6:] = velocity
        return State(q, v)

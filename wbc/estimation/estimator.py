"""State, contacts and foot loads of the whole robot from sensor readings."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import NoReturn

import numpy as np
import pinocchio as pin

from wbc.errors import MeasurementError, short_repr
from wbc.estimation.contact import ContactDetector, ContactTrigger
from wbc.estimation.estimate import Estimate
from wbc.estimation.inekf import InvariantFilter
from wbc.estimation.joints import JointFilter
from wbc.estimation.kernels.legs import write_state
from wbc.estimation.kernels.prediction import CORRECTION_DUE, REFUSED, predict
from wbc.estimation.legs import LegKinematics, leg_covariance
from wbc.estimation.noise import EstimatorNoise
from wbc.estimation.readings import is_array_of_numbers, is_vector_of_numbers
from wbc.estimation.tipping import TippingSoles
from wbc.estimation.wrench_observer import WrenchObserver
from wbc.measurement import Measurement
from wbc.robot import Robot, checked_robot
from wbc.state import State

#: Without foot sensors, soles within this of the lowest one are taken to stand, m.
_LEVEL = 0.005


class Estimator:
    """State of a walking robot from encoders, IMU and foot forces.

    The base comes from an `InvariantFilter` at the IMU's frame, corrected by the soles
    that stand; the joints from a `JointFilter`. Neither the heading nor the position on the
    ground is measured by any sensor: both start from `reset` and drift slowly, by
    touchdowns and slip. Only what a real robot measures is read; the exact state of a
    simulator goes through `GroundTruthEstimator`.

    Which soles stand is decided from the foot forces by `trigger`. A robot without foot sensors
    whose joint torques are measured has those of a `WrenchObserver`. They correct the base but are
    no foot loads of the estimate: a controller then times its contacts by its plan. Without either
    it is what `contacts` says, and without that the soles that the estimate places lowest: good for
    standing and slow walking on flat floor, not for running or stairs.

    At any tick `copy.deepcopy` and `pickle` give an estimator that goes on bit-identically,
    in this process or another.

    Args:
        robot: its model gives the kinematics; the IMU is at the frame `robot.imu`.
        dt: period of `update`, s.
        noise: assumed noise of sensors and feet.
        trigger: decides on contacts.
        joint_acceleration: standard deviation of a joint's acceleration, rad/s²: the
            bandwidth of the joint filter; infinity switches it off. On a walking Talos
            and a walking G1, readings of 0.05 rad/s come out at 0.033 and 0.039 with 20,
            at 0.038 and 0.061 with 10 by lag, at 0.040 and 0.040 with 40.
        joint_surprise: the same for the part of the acceleration that the command did not
            foresee, when `update` is given it; that brings 0.019 and 0.022.
        correct_every: periods between two corrections by the legs; touchdowns are taken
            in at once. The joint filter bridges the encoders' readings in between: the
            errors of 1, 2, 4 and 8 differ by less than a tenth.

    Raises:
        MeasurementError: a period, deviation or count that is not positive.
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
        if not (math.isfinite(dt) and dt > 0.0):
            raise MeasurementError(
                f"Estimator: dt = {dt} s must be positive and finite: the plant's control period"
            )
        for name, value in (
            ("joint_acceleration", joint_acceleration),
            ("joint_surprise", joint_surprise),
            ("correct_every", correct_every),
        ):
            if not value > 0:
                raise MeasurementError(f"Estimator: {name} = {value} must be positive")
        self.robot = checked_robot(robot, "Estimator")
        self.dt = dt
        self._noise = EstimatorNoise() if noise is None else noise
        encoder, joint_velocity = self._noise.joint_readings
        self._detector = ContactDetector(robot, trigger)
        self._legs = LegKinematics(robot)
        self._tipping = TippingSoles(robot, self._noise.tip)
        self.filter = InvariantFilter(
            dt,
            np.array(robot.model.gravity.linear),
            self._noise,
            [leg_covariance(robot, i, encoder) for i in range(len(robot.soles))],
            robot.point_feet,
            every=correct_every,
        )
        self._joints = JointFilter(
            robot.na,
            dt,
            encoder,
            joint_velocity,
            joint_acceleration,
            joint_surprise,
        )
        legs = self._legs
        self._filters = (
            self.filter.record,
            self._detector.slip,
            self._joints.state,
            legs.links,
            legs.ends,
            legs.poses,
        )
        self._wrench_observer: WrenchObserver | None = None
        self._no_acceleration = np.zeros(robot.na)
        self._shapes = ((robot.na,), (robot.na,), (robot.na,), (3,), (3,))
        self._nq, self._nv = robot.nq, robot.nv
        self.reset(robot.standing())

    def __repr__(self) -> str:
        contacts = ", ".join(self.contacts) or "none"
        return f"Estimator({self.robot.name}, dt={self.dt} s, contacts: {contacts})"

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the soles that are taken to stand."""
        return self._detector.contacts

    def reset(self, state: State) -> None:
        """Start at a state whose position, heading and posture are taken as true.

        Roll, pitch and velocity may be off by what `noise` says; biases are unknown.

        Raises:
            StateError: wrong sizes, NaN or a quaternion that is not of unit length.
        """
        state = state.validated(self.robot.model)
        model = self.robot.model
        data = model.createData()
        pin.forwardKinematics(model, data, state.q, state.v)
        imu = self.robot.frame_id(self.robot.imu)
        world = pin.updateFramePlacement(model, data, imu)
        velocity = pin.getFrameVelocity(model, data, imu, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        self.filter.reset(world.rotation, velocity.linear, world.translation)
        self._joints.fresh = True
        self._detector.reset()
        if self._wrench_observer is not None:
            self._wrench_observer.reset()

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
            measurement: readings of the sensors; its `ground_truth` is not used.
            contacts: names of the soles that stand, instead of deciding by the foot forces.
            acceleration: (nv,) what the last command was to bring about
                (`Command.acceleration`), m/s² and rad/s²; takes the lag out of the joint
                filter.

        Returns:
            An estimate whose state has new arrays: base pose in the world, base twist in the
            base frame, filtered joints.

        Raises:
            MeasurementError: a wrong size, a reading or acceleration that is not finite, or foot
                wrenches of some soles only.
            ContactError: an unknown sole in `contacts`.
        """
        detector, measured = self._detector, measurement.foot_wrenches
        before = detector.stands
        wrenches: Mapping[str, np.ndarray] = measured
        if not wrenches and contacts is None and measurement.joint_torque is not None:
            wrenches = self._observed_wrenches(measurement)
        loads = detector.update(wrenches, contacts)
        q, v = np.empty(self._nq), np.empty(self._nv)
        outcome = self._predict(measurement, acceleration, q, v)
        if outcome == REFUSED:
            detector.decide(before)
            self._refuse(measurement, acceleration)
        if loads is None and contacts is None:
            detector.decide(self._lowest())
        due, stands = outcome == CORRECTION_DUE, detector.stands
        if due or stands != before:
            self._correct(before, stands, due, measured)
            write_state(self.filter.record, self._legs.poses, self._joints.state, q, v)
        if not measured:
            # Observed loads lag and chatter: steps that are timed by them become shorter.
            loads = None
        return Estimate(State(q, v), detector.contacts, loads, measured)

    def _observed_wrenches(self, measurement: Measurement) -> Mapping[str, np.ndarray]:
        """Return the wrenches on the soles by the joints' torques."""
        m, observer = measurement, self._wrench_observer
        if observer is None:
            observer = self._wrench_observer = WrenchObserver(self.robot, self.dt)
        if self._joints.fresh:
            return observer.update(m, m.joint_position, m.joint_velocity)
        return observer.update(m, *self._joints.state)

    def _predict(
        self,
        measurement: Measurement,
        acceleration: np.ndarray | None,
        q: np.ndarray,
        v: np.ndarray,
    ) -> int:
        """Take in the readings of joints and IMU, and write the state; see `predict`."""
        m, joints = measurement, self._joints
        filters = (*self._filters, joints.update_matrix(acceleration is not None), q, v)
        if acceleration is None:
            foreseen = self._no_acceleration
        elif isinstance(acceleration, np.ndarray) and acceleration.ndim == 1:
            foreseen = acceleration[6:]
        else:
            return REFUSED
        readings = (foreseen, m.joint_position, m.joint_velocity, m.gyro, m.accelerometer)
        try:
            outcome = predict(*filters, *readings)
        except (AttributeError, TypeError):  # other numbers than floats, not contiguous, read-only
            if not all(is_vector_of_numbers(x) for x in readings):
                return REFUSED
            outcome = predict(*filters, *(np.array(x, dtype=float) for x in readings))
        if outcome != REFUSED:
            joints.fresh = False
        return int(outcome)

    def _refuse(self, measurement: Measurement, acceleration: np.ndarray | None) -> NoReturn:
        names = ("joint_position", "joint_velocity", "gyro", "accelerometer")
        for name, shape in zip(names, self._shapes[1:], strict=True):
            reading = getattr(measurement, name)
            if not is_array_of_numbers(reading):
                raise MeasurementError(
                    f"measurement.{name} is {short_repr(reading)}: it must be an array of numbers"
                )
            if reading.shape != shape:
                raise MeasurementError(
                    f"measurement.{name} has shape {reading.shape}, the robot needs {shape}"
                )
            if not np.isfinite(reading).all():
                first = int(np.flatnonzero(~np.isfinite(reading))[0])
                raise MeasurementError(
                    f"measurement.{name}[{first}] is {reading[first]}: readings must be finite; "
                    "look at the sensor or its driver"
                )
        raise MeasurementError(
            f"acceleration is {short_repr(acceleration)}: give finite numbers of shape "
            f"({self._nv},), such as those of the last command, or None"
        )

    def _lowest(self) -> list[bool]:
        heights = (self._legs.sole_positions @ self.filter.R[2]).tolist()
        return [height < min(heights) + _LEVEL for height in heights]

    def _correct(
        self,
        before: list[bool],
        stands: list[bool],
        due: bool,
        wrenches: Mapping[str, np.ndarray],
    ) -> None:
        """Correct by the soles that stood and stand; take in those that came down."""
        h, F = self._legs.sole_positions, self._legs.sole_rotations
        if due:
            held = [now and then for now, then in zip(stands, before, strict=True)]
            if wrenches:
                self._tipping.add(self.filter.record, held, wrenches, self.filter.period)
            self.filter.correct(np.array(held, dtype=np.int64), h, F)
        for i, now in enumerate(stands):
            if now and not before[i]:
                self.filter.land(i, h[i], F[i])

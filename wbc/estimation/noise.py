"""The noise that the estimator assumes of the sensors and the feet."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wbc.errors import MeasurementError

_CROSSING_TIME = 0.02  # s in which a motor crosses its play


@dataclass(frozen=True, slots=True)
class EstimatorNoise:
    """Standard deviations that the estimator assumes.

    White noise is per sample of one control period. Most of it hardly matters: on flat
    floor, halving or doubling moves a walking robot's velocity error by less than a
    third. `rock` does on tiles: assuming a tilted sole fixed trebles it.

    Attributes:
        gyro: rad/s.
        accelerometer: m/s²; above the sensor's own noise, for what the sampled signal
            does not tell: vibration and impacts.
        gyro_walk: random walk of the gyro's bias, rad/s per √s.
        accelerometer_walk: random walk of the accelerometer's bias, m/s² per √s.
        gyro_bias: unknown bias of the gyro at a reset, rad/s.
        accelerometer_bias: unknown bias of the accelerometer at a reset, m/s².
        encoder: joint position, rad.
        joint_velocity: rad/s.
        backlash: play between the motors, where the encoders are, and the joints, rad: readings
            are off by half of it, and change by that within 20 ms. Taken for a motion of the robot,
            that is as fast as a push: an estimate of a robot with a play of 0.5° that does not know
            of it has the DCM off by 3 cm in every step.
        slip: random walk of a fully loaded sole, m per √s.
        twist: turning of a fully loaded sole about the vertical, rad per √s.
        rock: tilting of a fully loaded sole, rad per √s: large for uneven ground, where a
            sole rolls over edges; a tilt that is assumed fixed would bias the velocity.
        tip: rate at which a sole turns over an edge where its pressure is, rad/s; 0: none does.
        pivot: turning of a foot that touches the ground at a point, rad per √s: it turns with its
            leg, so that nothing is known of it.
        slip_gate: χ² of a sole's six readings from which on it has slipped; noise alone
            gets there once in 3000 corrections; infinity: a slip is never detected.
        jump: speed, m/s: when all soles that stand have it at once, a shock may have moved the
            robot that the accelerometer has not told. A sole that slips on a ground with
            friction 0.3 has 0.1 m/s when it is found, and gains 0.05 m/s per correction.
            Infinity: it is always the soles that have slipped.
        tilt: error of the tilt given at a reset, rad.
        speed: error of the velocity given at a reset, m/s.

    Raises:
        MeasurementError: a value that is negative or not finite.
    """

    gyro: float = 0.005
    accelerometer: float = 0.2
    gyro_walk: float = 1e-4
    accelerometer_walk: float = 1e-3
    gyro_bias: float = 0.005
    accelerometer_bias: float = 0.05
    encoder: float = 1e-3
    joint_velocity: float = 0.05
    backlash: float = 0.0
    slip: float = 0.003
    twist: float = 0.005
    rock: float = 0.05
    tip: float = 3.0
    pivot: float = 10.0
    slip_gate: float = 25.0
    jump: float = 0.4
    tilt: float = 0.01
    speed: float = 0.05

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if not (value >= 0.0 and (math.isfinite(value) or name in ("slip_gate", "jump"))):
                raise MeasurementError(
                    f"EstimatorNoise: {name} = {value} must be finite and not negative"
                )

    @property
    def joint_readings(self) -> tuple[float, float]:
        """Standard deviations of joint positions, rad, and velocities, rad/s, with the backlash."""
        off = 0.5 * self.backlash
        return math.hypot(self.encoder, off), math.hypot(self.joint_velocity, off / _CROSSING_TIME)

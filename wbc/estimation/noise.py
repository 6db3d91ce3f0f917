"""What the estimator believes about the sensors and the feet."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class EstimatorNoise:
    """Standard deviations that the estimator assumes.

    White noise is per sample of one control period. The estimate is insensitive: on a
    walking Talos and G1, halving or doubling any of these moves the velocity error by
    less than a third.

    Attributes:
        gyro: rad/s.
        accelerometer: m/s²; above the sensor's own noise, for what the sampled signal
            does not tell: vibration and impacts.
        gyro_walk: of the gyro's bias, rad/s per √s.
        accelerometer_walk: of the accelerometer's bias, m/s² per √s.
        gyro_bias: of the unknown bias at a reset, rad/s.
        accelerometer_bias: of the unknown bias at a reset, m/s².
        encoder: joint position, rad.
        joint_velocity: rad/s.
        slip: wandering of a fully loaded sole, m per √s.
        twist: turning of a fully loaded sole, rad per √s.
        tilt: of the state given at a reset, rad.
        speed: of the state given at a reset, m/s.
    """

    gyro: float = 0.005
    accelerometer: float = 0.2
    gyro_walk: float = 1e-4
    accelerometer_walk: float = 1e-3
    gyro_bias: float = 0.005
    accelerometer_bias: float = 0.05
    encoder: float = 1e-3
    joint_velocity: float = 0.05
    slip: float = 0.003
    twist: float = 0.003
    tilt: float = 0.01
    speed: float = 0.05

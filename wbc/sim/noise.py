"""Errors of the simulated sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wbc.errors import PlantError


@dataclass(frozen=True, slots=True)
class SensorNoise:
    """Standard deviations of the sensors' errors, per sample of one control period.

    White noise unless called a bias; a bias is drawn once per seed and stays.

    Orders of magnitude: joint encoders of 12 to 16 bit on the output side and
    their differentiated velocity, as measured on electric humanoids; IMU as in the
    data sheets of the industrial MEMS units that humanoids carry (gyro noise
    density 0.003 to 0.01 deg/s/√Hz, accelerometer 60 to 150 µg/√Hz, in-run bias
    after calibration below 0.15 deg/s and 2 mg), with a margin for the vibration
    of a walking machine; six-axis force sensors are linear to about 1 % of load.

    Attributes:
        encoder: joint position, rad.
        velocity: joint velocity, rad/s.
        gyro: angular velocity, rad/s.
        gyro_bias: constant error of the gyro, rad/s.
        accelerometer: specific force, m/s².
        accelerometer_bias: constant error of the accelerometer, m/s².
        force: foot force, N.
        force_share: foot force, as a share of the reading.
        torque: foot moment, N·m.
        joint_torque: measured torque of a joint, as a share of its limit.

    Raises:
        PlantError: a standard deviation that is negative or not finite.
    """

    encoder: float = 1e-3
    velocity: float = 0.05
    gyro: float = 0.005
    gyro_bias: float = 0.002
    accelerometer: float = 0.05
    accelerometer_bias: float = 0.02
    force: float = 1.0
    force_share: float = 0.01
    torque: float = 0.1
    joint_torque: float = 0.005

    def __post_init__(self) -> None:
        for name in self.__slots__:
            sigma = getattr(self, name)
            if not (math.isfinite(sigma) and sigma >= 0.0):
                raise PlantError(
                    f"SensorNoise: {name} = {sigma} is a standard deviation; it must be finite "
                    "and not negative (0 for a perfect sensor)"
                )

    @classmethod
    def none(cls) -> SensorNoise:
        """Return the noise of perfect sensors."""
        return cls(*(0.0,) * len(cls.__slots__))

    def scaled(self, factor: float) -> SensorNoise:
        """Return the noise of the same sensors, every deviation times `factor`."""
        return SensorNoise(*(factor * getattr(self, name) for name in self.__slots__))


class NoiseGenerator:
    """Draws the sensor errors of one run from a seeded generator.

    Args:
        sigma: the standard deviations.
        na: number of joints.
        feet: number of foot sensors.
        seed: the same seed gives the same errors, sample by sample.
        tau_max: torque limits of the joints whose torques are measured, N·m.

    Attributes:
        gyro_bias: (3,) of this run, IMU axes, rad/s.
        accelerometer_bias: (3,) of this run, IMU axes, m/s².
    """

    def __init__(
        self, sigma: SensorNoise, na: int, feet: int, seed: int, tau_max: ArrayLike = ()
    ) -> None:
        self._sigma = sigma
        self._random = np.random.default_rng(seed)
        bias = self._random.standard_normal(6)
        self.gyro_bias = sigma.gyro_bias * bias[:3]
        self.accelerometer_bias = sigma.accelerometer_bias * bias[3:]
        white = [sigma.encoder] * na + [sigma.velocity] * na
        white += [sigma.gyro] * 3 + [sigma.accelerometer] * 3
        white += ([sigma.force] * 3 + [sigma.torque] * 3) * feet
        self._forces = slice(2 * na + 6, len(white))
        self._scale = np.concatenate((white, sigma.joint_torque * np.asarray(tau_max)))
        self._offset = np.zeros(self._scale.size)
        self._offset[2 * na : 2 * na + 3] = self.gyro_bias
        self._offset[2 * na + 3 : 2 * na + 6] = self.accelerometer_bias

    def add_to(self, exact: np.ndarray) -> np.ndarray:
        """Return the readings (see `Sensors.reading`) with errors, in a new array."""
        forces = exact[self._forces]
        draw = self._random.standard_normal(exact.size + forces.size)
        noisy, in_proportion = draw[: exact.size], draw[exact.size :]
        noisy *= self._scale
        noisy += exact
        noisy += self._offset
        in_proportion *= self._sigma.force_share * forces
        noisy[self._forces] += in_proportion
        return noisy

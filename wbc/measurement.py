"""The readings of a humanoid's sensors at one instant."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from wbc.state import State


@dataclass(frozen=True, slots=True)
class Measurement:
    """Sensor readings of one control period.

    Attributes:
        time: s.
        joint_position: (na,) encoders, rad, model joint order.
        joint_velocity: (na,) rad/s.
        gyro: (3,) angular velocity of the IMU, rad/s, IMU axes.
        accelerometer: (3,) specific force (a − g) of the IMU, m/s², IMU axes.
            The IMU's frame is `robot.imu` (the base link unless stated).
        foot_wrenches: sole name -> (6,) force then moment that the ground exerts
            on the foot, at the sole's centre, in sole axes; N, N·m. Empty when
            the robot has no foot sensors.
        joint_torque: (na,) torques that the motors exert, N·m; None if they are not measured.
        ground_truth: the exact state, only from a simulator that was made with
            `ground_truth=True`.
    """

    time: float
    joint_position: np.ndarray
    joint_velocity: np.ndarray
    gyro: np.ndarray
    accelerometer: np.ndarray
    foot_wrenches: dict[str, np.ndarray] = field(default_factory=dict)
    ground_truth: State | None = None
    joint_torque: np.ndarray | None = None

    def __repr__(self) -> str:
        forces = ", ".join(f"{name} {w[2]:.0f} N" for name, w in self.foot_wrenches.items())
        return (
            f"Measurement(t = {self.time:.3f} s, {self.joint_position.size} joints, "
            f"gyro {np.array2string(self.gyro, precision=3)} rad/s, "
            f"accelerometer {np.array2string(self.accelerometer, precision=2)} m/s², "
            f"feet: {forces or 'no sensors'}"
            f"{', with ground truth' if self.ground_truth is not None else ''})"
        )

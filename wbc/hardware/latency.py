"""The time from a reading to the torque that answers it."""

from __future__ import annotations

import math

import numpy as np

from wbc.measurement import Measurement
from wbc.servo import ServoCommand

_DEPTH = 16  # periods
_FORGETTING = 0.999  # per period


class LatencyEstimator:
    """Finds the age of the command that a robot's measured torques answer to.

    For each age k, the torque of the servo law of the command k periods ago at the present reading
    is compared with the measured torque; the age with the least mean square is the latency, from
    one reading to the first one that shows the effect of its command.

    Args:
        joints: number of joints.
        dt: control period, s.

    Attributes:
        torque: norm of the torques of the command that explains the last reading best, N·m; 0 as
            long as that is unknown.
        torque_error: norm of the difference of the measured ones, N·m.
    """

    def __init__(self, joints: int, dt: float) -> None:
        self._dt = dt
        self._commands = np.zeros((_DEPTH, 5, joints))
        self._errors = np.zeros(_DEPTH)
        self._count = 0
        self.torque = self.torque_error = 0.0

    def commanded(self, command: ServoCommand) -> None:
        """Take in the command of a period."""
        row = self._commands[self._count % _DEPTH]
        row[0], row[1], row[2], row[3], row[4] = (
            command.q, command.v, command.tau, command.kp, command.kd,
        )  # fmt: skip
        self._count += 1

    def measured(self, m: Measurement) -> None:
        """Take in the reading of a period."""
        if m.joint_torque is None or self._count < _DEPTH:
            return
        q, v, tau, kp, kd = self._commands.transpose(1, 0, 2)
        torque = tau + kp * (q - m.joint_position) + kd * (v - m.joint_velocity)
        square = np.square(torque - m.joint_torque).sum(axis=1)
        best = int(square.argmin())
        self.torque = math.sqrt(torque[best].dot(torque[best]))
        self.torque_error = math.sqrt(square[best])
        ages = (self._count - 1 - np.arange(_DEPTH)) % _DEPTH
        self._errors *= _FORGETTING
        self._errors[ages] += square

    @property
    def seconds(self) -> float | None:
        """The latency, s: whole periods; None before there were enough readings."""
        if not self._errors.any():
            return None
        return (int(np.argmin(self._errors)) + 1) * self._dt

    @property
    def beyond_ideal(self) -> float:
        """The latency beyond the one period of an ideal robot, s; 0 as long as it is unknown."""
        return max((self.seconds or 0.0) - self._dt, 0.0)

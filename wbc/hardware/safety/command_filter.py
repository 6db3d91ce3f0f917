"""Keeps commands within the limits of a robot."""

from __future__ import annotations

import numpy as np

from wbc.hardware.safety.limits import SafetyLimits
from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.servo import ServoCommand


class CommandFilter:
    """Bounds positions, velocities and torques of servo commands, and the rate of the torques.

    Positions are kept in the joints' ranges, velocities within their limits; the feed-forward
    torque is bounded and rises no faster than allowed; and it is chosen so that the torque which
    the servo law gives at the last reading is within the limits.

    Args:
        robot: its joint limits.
        limits: the limits.
        dt: period of the commands, s.
    """

    def __init__(self, robot: Robot, limits: SafetyLimits, dt: float) -> None:
        self._low, self._high = robot.q_min, robot.q_max
        self._speed = np.asarray(robot.v_max)
        self._tau_max = limits.torque * np.asarray(robot.tau_max)
        self._step = self._tau_max * dt / limits.torque_rise
        self._tau = np.zeros(robot.na)

    def reset(self) -> None:
        """Start from no torque."""
        self._tau[:] = 0.0

    def apply(self, command: ServoCommand, m: Measurement) -> ServoCommand:
        """Return the command within the limits; the reading is the last one."""
        limit = self._tau_max
        q = np.minimum(np.maximum(command.q, self._low), self._high)
        v = np.minimum(np.maximum(command.v, -self._speed), self._speed)
        feedback = command.kp * (q - m.joint_position) + command.kd * (v - m.joint_velocity)
        low, high = np.maximum(-limit, -limit - feedback), np.minimum(limit, limit - feedback)
        tau = np.minimum(np.maximum(command.tau, np.minimum(low, high)), np.maximum(low, high))
        tau = np.minimum(np.maximum(tau, self._tau - self._step), self._tau + self._step)
        tau = np.minimum(np.maximum(tau, -limit), limit)
        self._tau = tau
        return ServoCommand(q, v, tau, command.kp, command.kd)

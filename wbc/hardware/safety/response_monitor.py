"""Finds that a robot does not answer its commands."""

from __future__ import annotations

import numpy as np

from wbc.hardware.latency import LatencyEstimator
from wbc.hardware.safety.limits import SafetyLimits
from wbc.measurement import Measurement
from wbc.robot import Robot

_LEAST_TORQUE = 0.02  # share of the torque limits, below which noise hides what was commanded


class ResponseMonitor:
    """Compares the measured torques with those of the commands sent lately.

    A robot whose command wire is lost damps its joints, or its motors are off: no command explains
    its torques then.

    Args:
        robot: its torque limits.
        limits: the limits.
        dt: control period, s.

    Attributes:
        latency: measures the time from a reading to the torque that answers it.
    """

    def __init__(self, robot: Robot, limits: SafetyLimits, dt: float) -> None:
        self.latency = LatencyEstimator(robot.na, dt)
        self._limits = limits
        self._least = _LEAST_TORQUE * float(np.linalg.norm(robot.tau_max))
        self._answered_at = 0.0

    def fault(self, m: Measurement) -> str:
        """Return what is wrong with the torques of a reading; an empty text if nothing is."""
        self.latency.measured(m)
        error, torque = self.latency.torque_error, self.latency.torque
        if torque < self._least or error <= self._limits.torque_error * torque:
            self._answered_at = m.time
        elif m.time - self._answered_at > self._limits.unanswered - 1e-9:
            return (
                f"the measured torques have not answered the commands for "
                f"{1e3 * (m.time - self._answered_at):.0f} ms: the commands do not arrive, or the "
                "motors are off or have another order than the model's joints"
            )
        return ""

"""The motors: torque limits and command latency."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from wbc.command import Command
from wbc.errors import PlantError
from wbc.robot import Robot


class Motors:
    """Limits and delays torque commands.

    Args:
        robot: its torque limits.
        latency: age of a command when it reaches the motors, physics steps.
    """

    def __init__(self, robot: Robot, latency: int) -> None:
        self._joint_names = robot.joint_names
        self._tau_max = np.array(robot.tau_max, dtype=float)
        self._tau_min = -self._tau_max
        self._latency = latency
        self._queue: deque[tuple[int, np.ndarray]] = deque()

    def clear(self) -> None:
        """Forget the commands that have not arrived."""
        self._queue.clear()

    def command(self, command: Command, step: int) -> None:
        """Send a command's torques at a physics step, clipped to the limits.

        Args:
            command: its `tau` is used.
            step: physics steps since the reset. The first command acts at once: a robot is
                never switched on without one.

        Raises:
            PlantError: a wrong size, or torques that are not finite.
        """
        tau = np.asarray(command.tau, dtype=float)
        if tau.shape != self._tau_max.shape:
            raise PlantError(
                f"command.tau has shape {tau.shape}, the robot has {self._tau_max.size} joints"
            )
        if not math.isfinite(tau.dot(tau)) and not np.isfinite(tau).all():
            first = int(np.flatnonzero(~np.isfinite(tau))[0])
            raise PlantError(
                f"command.tau of joint '{self._joint_names[first]}' is {tau[first]}: torques "
                "must be finite (N·m); look at the controller behind it"
            )
        clipped = np.minimum(np.maximum(tau, self._tau_min), self._tau_max)
        self._queue.append((step + self._latency if step else 0, clipped))

    def arrived(self, step: int) -> np.ndarray | None:
        """Return the newest torques that have arrived by a physics step, or None; (na,) N·m."""
        tau = None
        while self._queue and self._queue[0][0] <= step:
            tau = self._queue.popleft()[1]
        return tau

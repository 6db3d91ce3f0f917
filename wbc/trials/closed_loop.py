"""A plant, an estimator and a controller in closed loop, which can be forked at any tick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wbc.command import Command
from wbc.estimation import Estimate
from wbc.robot import Robot
from wbc.runtime.protocols import StateEstimator, VelocityController
from wbc.sim import Mujoco


@dataclass(slots=True)
class ClosedLoop:
    """A closed loop; pickled, it goes on bit-identically in any process.

    Attributes:
        robot: the nominal robot, which estimator and controller know; the plant's may differ.
        plant: the simulated robot.
        estimator: measurement to estimate.
        controller: estimate to command.
        expected: acceleration that the last command was to bring about, (nv,).
    """

    robot: Robot
    plant: Mujoco
    estimator: StateEstimator
    controller: VelocityController
    expected: np.ndarray | None = None

    def reset(self) -> None:
        """Start at the plant's reset, standing."""
        self.plant.reset()
        state = self.plant.ground_truth()
        self.estimator.reset(state)
        self.controller.reset(state)
        self.expected = None

    def tick(self) -> tuple[Estimate, Command]:
        """Measure, estimate, control, act; return estimate and command."""
        estimate = self.estimator.update(self.plant.measure(), acceleration=self.expected)
        command = self.controller.step(estimate)
        self.expected = command.acceleration
        self.plant.step(command)
        return estimate, command

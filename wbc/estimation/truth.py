"""The simulator's exact state in place of an estimate."""

from __future__ import annotations

import numpy as np

from wbc.errors import MeasurementError
from wbc.estimation.contact import ContactDetector, ContactTrigger
from wbc.estimation.estimate import Estimate
from wbc.measurement import Measurement
from wbc.robot import Robot, checked_robot
from wbc.state import State


class GroundTruthEstimator:
    """Passes `measurement.ground_truth` on: for tests, and to find what estimation costs.

    Contacts and loads come from the foot sensors, as in `Estimator`.

    Args:
        robot: the robot.
        trigger: decides on contacts.
    """

    def __init__(self, robot: Robot, trigger: ContactTrigger | None = None) -> None:
        self._detector = ContactDetector(checked_robot(robot, "GroundTruthEstimator"), trigger)

    def reset(self, state: State) -> None:
        """Start with all soles in the air; the first measurement tells which stand."""
        self._detector.reset()

    def update(
        self, measurement: Measurement, *, acceleration: np.ndarray | None = None
    ) -> Estimate:
        """Return the exact state, and contacts and loads by the foot sensors.

        Raises:
            MeasurementError: the measurement has no ground truth, or a bad foot wrench.
        """
        if measurement.ground_truth is None:
            raise MeasurementError(
                "the measurement carries no ground truth: only a plant that was made with "
                "ground_truth=True delivers it, and no real robot does"
            )
        detector = self._detector
        loads = detector.update(measurement.foot_wrenches)
        return Estimate(
            measurement.ground_truth, detector.contacts, loads, measurement.foot_wrenches
        )

"""No estimation at all: the simulator's exact state."""

from __future__ import annotations

import numpy as np

from wbc.errors import MeasurementError
from wbc.measurement import Measurement
from wbc.state import State


class GroundTruthEstimator:
    """Hands on `measurement.ground_truth`: for tests, and to tell what estimation costs."""

    def reset(self, state: State) -> None:
        """Nothing to start."""

    def update(self, measurement: Measurement, *, acceleration: np.ndarray | None = None) -> State:
        """The exact state.

        Raises:
            MeasurementError: the measurement has none.
        """
        if measurement.ground_truth is None:
            raise MeasurementError(
                "the measurement carries no ground truth: only a plant that was made with "
                "ground_truth=True delivers it, and no real robot does"
            )
        return measurement.ground_truth

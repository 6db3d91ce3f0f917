"""An estimator whose estimates tell the controller nothing of contacts and foot loads."""

from __future__ import annotations

import numpy as np

from wbc.estimation import Estimate
from wbc.measurement import Measurement
from wbc.runtime.protocols import StateEstimator
from wbc.state import State


class ContactByTime:
    """Gives the controller the state alone, so that contact goes by its plan.

    Args:
        estimator: estimates the state, with the foot sensors if it uses them.
    """

    def __init__(self, estimator: StateEstimator) -> None:
        self._estimator = estimator

    def reset(self, state: State) -> None:
        """See `wbc.runtime.protocols.StateEstimator`."""
        self._estimator.reset(state)

    def update(
        self, measurement: Measurement, *, acceleration: np.ndarray | None = None
    ) -> Estimate:
        """See `wbc.runtime.protocols.StateEstimator`."""
        return Estimate(self._estimator.update(measurement, acceleration=acceleration).state)

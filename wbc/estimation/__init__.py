"""State estimation: from a `Measurement` to a `State`."""

from wbc.estimation.contact import ContactTrigger
from wbc.estimation.estimator import Estimator
from wbc.estimation.noise import EstimatorNoise
from wbc.estimation.truth import GroundTruthEstimator

__all__ = ["ContactTrigger", "Estimator", "EstimatorNoise", "GroundTruthEstimator"]

"""State estimation: from a `Measurement` to an `Estimate` of state, contacts and foot loads."""

from wbc.estimation.contact import ContactTrigger
from wbc.estimation.estimate import Estimate
from wbc.estimation.estimator import Estimator
from wbc.estimation.noise import EstimatorNoise
from wbc.estimation.truth import GroundTruthEstimator

__all__ = ["ContactTrigger", "Estimate", "Estimator", "EstimatorNoise", "GroundTruthEstimator"]

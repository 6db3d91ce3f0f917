"""The public names of `wbc.estimation`, each once."""

from .contact import ContactTrigger as ContactTrigger
from .estimate import Estimate as Estimate
from .estimator import Estimator as Estimator
from .hand_force import HandForceEstimator as HandForceEstimator
from .latency import LatencyCompensation as LatencyCompensation
from .noise import EstimatorNoise as EstimatorNoise
from .payload import PayloadEstimator as PayloadEstimator
from .truth import GroundTruthEstimator as GroundTruthEstimator

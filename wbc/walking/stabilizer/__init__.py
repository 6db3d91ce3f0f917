"""Stabilizer: feedback of the divergent component of motion, step adjustment, bias of the CoM."""

from wbc.walking.stabilizer.com_bias import ComBiasEstimator
from wbc.walking.stabilizer.dcm_feedback import zmp_from_dcm_error
from wbc.walking.stabilizer.push_recovery import PushRecovery
from wbc.walking.stabilizer.stabilizer import Stabilizer, StabilizerOutput
from wbc.walking.stabilizer.step_adjustment import footstep_adjustment, uncaught_dcm_error
from wbc.walking.stabilizer.support_polygon import SupportPolygon

__all__ = [
    "ComBiasEstimator",
    "PushRecovery",
    "Stabilizer",
    "StabilizerOutput",
    "SupportPolygon",
    "footstep_adjustment",
    "uncaught_dcm_error",
    "zmp_from_dcm_error",
]

"""Stabilizer: feedback of the divergent component of motion, step adjustment, bias of the CoM."""

from wbc.walking.stabilizer.com_bias import ComBias
from wbc.walking.stabilizer.dcm_feedback import feedback_zmp
from wbc.walking.stabilizer.step_adjustment import step_shift

__all__ = ["ComBias", "feedback_zmp", "step_shift"]

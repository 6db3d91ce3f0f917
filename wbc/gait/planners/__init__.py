"""Planners of footsteps and DCM: the protocol, and the analytic DCM planner."""

from wbc.gait.planners.dcm import DcmReference, ZmpSegment, solve_dcm
from wbc.gait.planners.dcm_planner import PREVIEW_STEPS, DcmPlanner
from wbc.gait.planners.planner import Planner, StepPlan

__all__ = [
    "PREVIEW_STEPS",
    "DcmPlanner",
    "DcmReference",
    "Planner",
    "StepPlan",
    "ZmpSegment",
    "solve_dcm",
]

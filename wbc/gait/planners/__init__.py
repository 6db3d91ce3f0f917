"""Planners of footsteps and DCM: the protocol, and the planners of the library."""

from wbc.gait.planners.dcm import DcmReference, ZmpSegment, solve_dcm
from wbc.gait.planners.dcm_planner import PREVIEW_STEPS, DcmPlanner
from wbc.gait.planners.mpc_planner import MpcPlanner
from wbc.gait.planners.placo_planner import PlacoPlanner
from wbc.gait.planners.planner import PlanFailed, Planner, StepPlan
from wbc.gait.planners.preview_control_planner import PreviewControlPlanner
from wbc.gait.planners.registry import PLANNER_NAMES, make_planner, resolve_planner

__all__ = [
    "PLANNER_NAMES",
    "PREVIEW_STEPS",
    "DcmPlanner",
    "DcmReference",
    "MpcPlanner",
    "PlacoPlanner",
    "PlanFailed",
    "Planner",
    "PreviewControlPlanner",
    "StepPlan",
    "ZmpSegment",
    "make_planner",
    "resolve_planner",
    "solve_dcm",
]

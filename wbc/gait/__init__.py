"""Gait: footsteps, phases, planners of footsteps and DCM, and the swing foot."""

from wbc.gait.footsteps import Velocity, next_footstep
from wbc.gait.lifted_foot import LiftedFoot
from wbc.gait.parameters import GaitParameters
from wbc.gait.planners import DcmPlanner, DcmReference, Planner, StepPlan, ZmpSegment, solve_dcm
from wbc.gait.state import GaitCommand, GaitState, Phase, PlannedFootstep
from wbc.gait.state_machine import GaitStateMachine
from wbc.gait.swing_foot import SwingFoot
from wbc.geometry.planar import Feet, Placement

__all__ = [
    "DcmPlanner",
    "DcmReference",
    "Feet",
    "GaitCommand",
    "GaitParameters",
    "GaitState",
    "GaitStateMachine",
    "LiftedFoot",
    "Phase",
    "Placement",
    "PlannedFootstep",
    "Planner",
    "StepPlan",
    "SwingFoot",
    "Velocity",
    "ZmpSegment",
    "next_footstep",
    "solve_dcm",
]

"""Gait: footsteps, phases, planners of footsteps and DCM, and the swing foot."""

from wbc.gait.footsteps import Velocity, next_footstep
from wbc.gait.hop import Hop
from wbc.gait.lifted_foot import LiftedFoot
from wbc.gait.parameters import GaitParameters
from wbc.gait.phase import STAND, SWING, TRANSFER, Phase
from wbc.gait.planners import (
    DcmPlanner,
    DcmReference,
    MpcPlanner,
    PlacoPlanner,
    PlanFailed,
    Planner,
    PreviewControlPlanner,
    StepPlan,
    ZmpSegment,
    make_planner,
    solve_dcm,
)
from wbc.gait.quadruped_gait import PACE, TROT, WALK, QuadrupedGait
from wbc.gait.state import GaitCommand, GaitState, PlannedFootstep
from wbc.gait.state_machine import GaitStateMachine
from wbc.gait.swing_foot import SwingFoot
from wbc.gait.velocity_limits import VelocityLimits
from wbc.gait.walkability import check_walking
from wbc.geometry.planar import Feet, Placement

__all__ = [
    "PACE",
    "STAND",
    "SWING",
    "TRANSFER",
    "TROT",
    "WALK",
    "DcmPlanner",
    "DcmReference",
    "Feet",
    "GaitCommand",
    "GaitParameters",
    "GaitState",
    "GaitStateMachine",
    "Hop",
    "LiftedFoot",
    "MpcPlanner",
    "Phase",
    "Placement",
    "PlacoPlanner",
    "PlanFailed",
    "PlannedFootstep",
    "Planner",
    "PreviewControlPlanner",
    "QuadrupedGait",
    "StepPlan",
    "SwingFoot",
    "Velocity",
    "VelocityLimits",
    "ZmpSegment",
    "check_walking",
    "make_planner",
    "next_footstep",
    "solve_dcm",
]

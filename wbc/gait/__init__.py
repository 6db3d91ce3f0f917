"""The gait: footsteps, phases, the DCM plan and the swing foot."""

from wbc.gait.dcm import DcmReference, ZmpSegment, solve_dcm
from wbc.gait.footsteps import Velocity, next_footstep
from wbc.gait.lifted_foot import LiftedFoot
from wbc.gait.parameters import GaitParameters
from wbc.gait.state_machine import GaitStateMachine, Phase
from wbc.gait.swing_foot import SwingFoot
from wbc.geometry.planar import Feet, Placement

__all__ = [
    "DcmReference",
    "Feet",
    "GaitParameters",
    "GaitStateMachine",
    "LiftedFoot",
    "Phase",
    "Placement",
    "SwingFoot",
    "Velocity",
    "ZmpSegment",
    "next_footstep",
    "solve_dcm",
]

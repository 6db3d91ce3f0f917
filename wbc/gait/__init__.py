"""The gait: footsteps, phases, the DCM plan and the swing foot."""

from wbc.gait.dcm_plan import DcmReference, ZmpSegment, dcm_now
from wbc.gait.footsteps import Velocity, next_placement
from wbc.gait.lifted import LiftedFoot
from wbc.gait.parameters import GaitParameters
from wbc.gait.planar import Feet, Placement
from wbc.gait.schedule import Phase, Schedule
from wbc.gait.swing import SwingFoot

__all__ = [
    "DcmReference",
    "Feet",
    "GaitParameters",
    "LiftedFoot",
    "Phase",
    "Placement",
    "Schedule",
    "SwingFoot",
    "Velocity",
    "ZmpSegment",
    "dcm_now",
    "next_placement",
]

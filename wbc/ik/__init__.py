"""Inverse kinematics: postures on both feet, and the joint torques that hold them."""

from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_checks import HoldingEffort, holding_effort, max_effort_along, pelvis_violation
from wbc.ik.posture_ik import PostureIK

__all__ = [
    "HoldingEffort",
    "PostureIK",
    "PostureObjective",
    "PostureSolution",
    "holding_effort",
    "max_effort_along",
    "pelvis_violation",
]

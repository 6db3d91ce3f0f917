"""Inverse kinematics: velocities and postures from tasks and limits, postures on both feet."""

from wbc.ik.errors import InverseKinematicsError, NoSolutionFound
from wbc.ik.inverse_kinematics import InverseKinematics
from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_checks import HoldingEffort, holding_effort, max_effort_along, pelvis_violation
from wbc.ik.posture_ik import PostureIK
from wbc.ik.reach import ReachSolution

__all__ = [
    "HoldingEffort",
    "InverseKinematics",
    "InverseKinematicsError",
    "NoSolutionFound",
    "PostureIK",
    "PostureObjective",
    "PostureSolution",
    "ReachSolution",
    "holding_effort",
    "max_effort_along",
    "pelvis_violation",
]

"""Jumping: planned from the robot's limits, controlled in the air and on landing."""

from wbc.motions.jumping.bound import TakeOffBound, take_off_bound
from wbc.motions.jumping.controller import JumpController, JumpPhase
from wbc.motions.jumping.gains import JumpGains
from wbc.motions.jumping.path import JumpPath
from wbc.motions.jumping.path_search import find_path
from wbc.motions.jumping.plan import JumpPlan, JumpTooHigh, jump_paths, plan_jump

__all__ = [
    "JumpController",
    "JumpGains",
    "JumpPath",
    "JumpPhase",
    "JumpPlan",
    "JumpTooHigh",
    "TakeOffBound",
    "find_path",
    "jump_paths",
    "plan_jump",
    "take_off_bound",
]

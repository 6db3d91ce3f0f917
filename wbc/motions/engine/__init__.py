"""The engine of motions: what a motion's script is given, and what plays it.

A motion imports `Motion`, `parameter` and `MotionContext` from here; the engine imports no
motion.
"""

from wbc.motions.engine.clock import Script
from wbc.motions.engine.context import MotionContext
from wbc.motions.engine.manager import ZERO_VELOCITY, MotionManager, MotionStatus
from wbc.motions.engine.motion import (
    Motion,
    MotionParameter,
    check_positive,
    once_per_robot,
    parameter,
)
from wbc.motions.engine.motion_reference import FrameTarget, MotionReference
from wbc.motions.engine.override import ControllerOverride
from wbc.motions.engine.packing import check_importable, pack, unpack
from wbc.motions.engine.parsing import create_motion, describe_motion, parse_motion
from wbc.motions.engine.planning import SWITCH_INTERVAL, MotionPlanner, PlannedMotion
from wbc.motions.engine.player import MotionPlayer
from wbc.motions.engine.reference import Path, SmoothReference

__all__ = [
    "SWITCH_INTERVAL",
    "ZERO_VELOCITY",
    "ControllerOverride",
    "FrameTarget",
    "Motion",
    "MotionContext",
    "MotionManager",
    "MotionParameter",
    "MotionPlanner",
    "MotionPlayer",
    "MotionReference",
    "MotionStatus",
    "Path",
    "PlannedMotion",
    "Script",
    "SmoothReference",
    "check_importable",
    "check_positive",
    "create_motion",
    "describe_motion",
    "once_per_robot",
    "pack",
    "parameter",
    "parse_motion",
    "unpack",
]

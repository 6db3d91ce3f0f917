"""Motions: what a humanoid does besides walking, with the walker's balance control."""

from wbc.motions.bow import Bow
from wbc.motions.brace import Brace
from wbc.motions.carry import Carry
from wbc.motions.demo import Demo
from wbc.motions.engine import (
    FrameTarget,
    Motion,
    MotionContext,
    MotionParameter,
    MotionPlayer,
    MotionReference,
    Script,
    SmoothReference,
    once_per_robot,
    pack,
    parameter,
    unpack,
)
from wbc.motions.hold_hand import HoldHand
from wbc.motions.jump import Jump
from wbc.motions.keyframes import Keyframes
from wbc.motions.look import Look
from wbc.motions.one_leg import OneLeg
from wbc.motions.push_cart import PushCart
from wbc.motions.reach import Reach
from wbc.motions.registry import MOTIONS, find_motion
from wbc.motions.sine import Sine
from wbc.motions.squat import Squat
from wbc.motions.step_in_place import StepInPlace
from wbc.motions.sway import Sway
from wbc.motions.wave import Wave

__all__ = [
    "MOTIONS",
    "Bow",
    "Brace",
    "Carry",
    "Demo",
    "FrameTarget",
    "HoldHand",
    "Jump",
    "Keyframes",
    "Look",
    "Motion",
    "MotionContext",
    "MotionParameter",
    "MotionPlayer",
    "MotionReference",
    "OneLeg",
    "PushCart",
    "Reach",
    "Script",
    "Sine",
    "SmoothReference",
    "Squat",
    "StepInPlace",
    "Sway",
    "Wave",
    "find_motion",
    "once_per_robot",
    "pack",
    "parameter",
    "unpack",
]

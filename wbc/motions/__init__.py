"""Motions: what a humanoid does besides walking, on the walker's balance."""

from wbc.motions.body import Body
from wbc.motions.bow import Bow
from wbc.motions.catalogue import CATALOGUE, find
from wbc.motions.intent import Intent, Target
from wbc.motions.jump import Jump
from wbc.motions.keyframes import Keyframes
from wbc.motions.look import Look
from wbc.motions.motion import Motion, Parameter, Script, once_per_robot, parameter
from wbc.motions.one_leg import OneLeg
from wbc.motions.packing import pack, unpack
from wbc.motions.performer import Performer
from wbc.motions.reach import Reach
from wbc.motions.reference import SmoothReference
from wbc.motions.show import Show
from wbc.motions.sine import Sine
from wbc.motions.squat import Squat
from wbc.motions.stepping import StepInPlace
from wbc.motions.sway import Sway
from wbc.motions.wave import Wave

__all__ = [
    "CATALOGUE",
    "Body",
    "Bow",
    "Intent",
    "Jump",
    "Keyframes",
    "Look",
    "Motion",
    "OneLeg",
    "Parameter",
    "Performer",
    "Reach",
    "Script",
    "Show",
    "Sine",
    "SmoothReference",
    "Squat",
    "StepInPlace",
    "Sway",
    "Target",
    "Wave",
    "find",
    "once_per_robot",
    "pack",
    "parameter",
    "unpack",
]

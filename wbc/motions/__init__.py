"""Motions: what a humanoid does besides walking, on the walker's balance."""

from wbc.motions.body import Body
from wbc.motions.intent import Intent, Target
from wbc.motions.motion import Motion, Script, parameter
from wbc.motions.performer import Performer
from wbc.motions.reference import SmoothReference
from wbc.motions.sway import Sway

__all__ = [
    "Body",
    "Intent",
    "Motion",
    "Performer",
    "Script",
    "SmoothReference",
    "Sway",
    "Target",
    "parameter",
]

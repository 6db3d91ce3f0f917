"""Walking: gait, balance control and the whole-body controller combined."""

from wbc.walking.command_checks import VelocityClamped
from wbc.walking.gains import WalkerGains
from wbc.walking.hand_contacts import HandContact, HandContacts
from wbc.walking.quadruped import QuadrupedWalker
from wbc.walking.reference_offset import ReferenceOffset, RotationOffset
from wbc.walking.walker import Walker
from wbc.walking.waypoint_follower import WaypointFollower

__all__ = [
    "HandContact",
    "HandContacts",
    "QuadrupedWalker",
    "ReferenceOffset",
    "RotationOffset",
    "VelocityClamped",
    "Walker",
    "WalkerGains",
    "WaypointFollower",
]

"""Walking: gait, balance control and the whole-body controller combined."""

from wbc.walking.gains import WalkerGains
from wbc.walking.hand_contacts import HandContact, HandContacts
from wbc.walking.reference_offset import ReferenceOffset, RotationOffset
from wbc.walking.walker import VelocityClamped, Walker
from wbc.walking.waypoint_follower import WaypointFollower

__all__ = [
    "HandContact",
    "HandContacts",
    "ReferenceOffset",
    "RotationOffset",
    "VelocityClamped",
    "Walker",
    "WalkerGains",
    "WaypointFollower",
]

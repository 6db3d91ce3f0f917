"""Walking: gait, balance and the whole-body controller put together."""

from wbc.walking.body_offset import Attitude, BodyOffset
from wbc.walking.gains import WalkerGains
from wbc.walking.walker import VelocityClamped, Walker

__all__ = ["Attitude", "BodyOffset", "VelocityClamped", "Walker", "WalkerGains"]

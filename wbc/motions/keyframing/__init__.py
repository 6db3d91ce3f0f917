"""Keyframes: postures and places over time, from files."""

from wbc.motions.keyframing.keyframe import Keyframe, KeyframeError, Value, Where
from wbc.motions.keyframing.reading import read_keyframes

__all__ = ["Keyframe", "KeyframeError", "Value", "Where", "read_keyframes"]

"""Keyframes: postures and positions over time, from files, and their plans."""

from wbc.motions.keyframing.keyframe import FilePosition, FileValue, Keyframe, KeyframeError
from wbc.motions.keyframing.reading import read_keyframes

__all__ = ["FilePosition", "FileValue", "Keyframe", "KeyframeError", "read_keyframes"]

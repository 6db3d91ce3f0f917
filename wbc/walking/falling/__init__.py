"""Falling: when a fall is unavoidable, and how the joints yield then."""

from wbc.walking.falling.fall_controller import FallController
from wbc.walking.falling.fall_detector import FallDetector

__all__ = ["FallController", "FallDetector"]

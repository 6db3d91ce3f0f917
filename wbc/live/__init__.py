"""Live page: velocity, motions, pushes, gait and gains of a running robot, from the browser."""

from wbc.live.errors import LiveError
from wbc.live.live import Live

__all__ = ["Live", "LiveError"]

"""A robot driven from the browser: walking, motions, pushes, gait and gains, while it runs."""

from wbc.live.errors import LiveError
from wbc.live.live import Live

__all__ = ["Live", "LiveError"]

"""Walking on four feet."""

from wbc.walking.quadruped.quadruped_walker import QuadrupedWalker

__all__ = ["QuadrupedWalker"]

"""What can go wrong between a node and the rest of the graph."""

from __future__ import annotations

from wbc.errors import WbcError


class RosError(WbcError):
    """A node, topic, service or action cannot be made or used as asked."""


class NameInvalid(RosError, ValueError):
    """A name that ROS 2 would refuse; the text says why."""


class NoAnswer(RosError, TimeoutError):
    """Nobody answered in time."""

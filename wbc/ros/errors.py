"""Errors of nodes, topics, services and actions."""

from __future__ import annotations

from wbc.errors import WbcError


class RosError(WbcError):
    """A node, topic, service or action cannot be created or used as requested."""


class InvalidName(RosError, ValueError):
    """A name breaks the naming rules of ROS 2; the message says which rule."""


class ResponseTimeout(RosError, TimeoutError):
    """A service or action did not respond in time."""

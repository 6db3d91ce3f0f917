"""Errors of learned policies."""

from __future__ import annotations

from wbc.errors import WbcError


class PolicyError(WbcError, ValueError):
    """A policy's files cannot be read, contradict each other, or do not fit the robot."""

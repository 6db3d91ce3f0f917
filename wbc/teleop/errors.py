"""Errors of teleoperation."""

from __future__ import annotations

from wbc.errors import WbcError


class CommandRefused(WbcError, ValueError):
    """A command cannot be carried out; the text names the value and the cure."""

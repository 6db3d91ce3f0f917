"""Errors of logs."""

from __future__ import annotations

from wbc.errors import WbcError


class LogError(WbcError):
    """A log cannot be written, read or understood; the text names the file and the cure."""

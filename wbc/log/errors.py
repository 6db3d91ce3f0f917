"""The error class of logs."""

from __future__ import annotations

from wbc.errors import WbcError


class LogError(WbcError):
    """A log cannot be written, read or parsed; the message names the file and the remedy."""

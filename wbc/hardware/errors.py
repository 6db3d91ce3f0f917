"""Errors of robots outside this process."""

from __future__ import annotations

from wbc.errors import WbcError


class HardwareError(WbcError):
    """A robot does not answer, is not the expected one, or is not ready to start."""

"""Errors of the live page."""

from __future__ import annotations

from wbc.errors import WbcError


class LiveError(WbcError):
    """The live page cannot be served."""

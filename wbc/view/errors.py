"""The error class of viewers."""

from __future__ import annotations

from wbc.errors import WbcError


class ViewerError(WbcError):
    """A viewer cannot start, or cannot show its input."""

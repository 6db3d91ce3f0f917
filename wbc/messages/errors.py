"""What can be wrong with a message."""

from __future__ import annotations

from wbc.errors import WbcError


class MessageError(WbcError, ValueError):
    """A type is unknown, its definition or its bytes are malformed, or a value does not fit."""

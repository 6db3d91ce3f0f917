"""What can be wrong with a message."""

from __future__ import annotations

from wbc.errors import WbcError


class MessageError(WbcError, ValueError):
    """A message type is unknown, its text or its bytes make no sense, or a value does not fit."""

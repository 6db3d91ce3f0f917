"""What can go wrong before anything is on the screen."""

from __future__ import annotations

from wbc.errors import WbcError


class ViewerError(WbcError):
    """The viewer cannot be started, or was handed something that it cannot show."""

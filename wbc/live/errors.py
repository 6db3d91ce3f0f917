"""Errors of the live page."""

from __future__ import annotations

from wbc.errors import WbcError


class LiveError(WbcError):
    """The page cannot be served."""


class BadRequest(LiveError, ValueError):
    """A message from a page that makes no sense; the text is its answer."""

"""The error class of logs."""

from __future__ import annotations

import importlib.util

from wbc.errors import MissingExtra, WbcError


class LogError(WbcError):
    """A log cannot be written, read or parsed; the message names the file and the remedy."""


def require_mcap() -> None:
    """Check that the package `mcap` is installed, without importing it.

    Raises:
        MissingExtra: It is not installed.
    """
    if importlib.util.find_spec("mcap") is None:
        raise MissingExtra("mcap", "log")

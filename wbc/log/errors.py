"""The error class of logs."""

from __future__ import annotations

import importlib.util

from wbc.errors import MissingExtra, WbcError


class LogError(WbcError):
    """A log cannot be written, read or parsed; the message names the file and the remedy."""


def require_packages() -> None:
    """Check that the packages `mcap` and `rosbags` are installed, without importing them.

    Raises:
        MissingExtra: One of them is not installed.
    """
    for package in ("mcap", "rosbags"):
        if importlib.util.find_spec(package) is None:
            raise MissingExtra(package, "log")

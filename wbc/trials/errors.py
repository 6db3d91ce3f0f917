"""Errors of trials."""

from __future__ import annotations

from wbc.errors import WbcError


class TrialError(WbcError, ValueError):
    """A grid of trials, a file of results or a controller under test is not as it must be."""


class ResultsError(TrialError):
    """Results cannot be written to their file, or be read from it."""

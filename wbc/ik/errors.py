"""Errors of inverse kinematics."""

from wbc.errors import WbcError


class NoSolutionFound(WbcError):
    """No velocity holds all limits and exact tasks; the text names the rows in conflict."""


class InverseKinematicsError(WbcError):
    """An argument of inverse kinematics cannot be what it is for."""

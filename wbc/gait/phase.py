"""Phases of the gait."""

from __future__ import annotations

from enum import Enum


class Phase(Enum):
    """Part of the gait cycle."""

    STAND = "stand"  #: both feet, at rest
    TRANSFER = "double"  #: both feet, the weight moves to the support foot
    SWING = "single"  #: the support foot alone


# A tick compares the phase some thirty times, and to look a member up takes an Enum 0.1 µs.
STAND, TRANSFER, SWING = Phase.STAND, Phase.TRANSFER, Phase.SWING

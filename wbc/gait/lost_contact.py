"""Feet that were knocked off the place where they stood."""

from __future__ import annotations

import math

from wbc.gait.footsteps import other_side
from wbc.gait.state import GaitState, Phase
from wbc.geometry.planar import Feet

_MOVED = 0.05  # m from where it stood from which on a foot without contact does not carry the robot
_EARLIEST = 0.03  # s of a swing after which the foot in the air may take over


def lost_foot(state: GaitState, stood: Feet, contacts: frozenset[str] | None) -> str | None:
    """Return the side of a foot that is to carry the robot and cannot: it was knocked away.

    A blow on a leg throws its foot off the ground at some metres per second. A controller that goes
    on holding that foot, and counts on its force, lifts the other one too, which alone carries the
    robot by now. Contact alone flickers under a blow: the foot also has to be elsewhere.

    In double support it has to be elsewhere as seen from the foot that carries. The robot as a
    whole may seem to move, by centimetres when a foot that has just landed bounces.

    Args:
        state: phase, feet and support.
        stood: soles when the phase began.
        contacts: sides of the soles that touch the ground; None when it is not measured.

    Returns:
        The side: of either foot in double support, of the support foot in a swing. None if there
        is no such foot, or if the other one does not touch the ground either.
    """
    if contacts is None or len(contacts) != 1 or state.lifted is not None or state.on_stairs:
        return None
    side = other_side(*contacts)
    if state.phase is Phase.SWING and (side != state.support or state.time < _EARLIEST):
        return None
    across, up = _way(stood, state.feet, side)
    if state.phase is not Phase.SWING:
        across_here, up_here = _way(stood, state.feet, other_side(side))
        across, up = across - across_here, up - up_here
    return side if math.hypot(abs(across), up) > _MOVED else None


def _way(before: Feet, now: Feet, side: str) -> tuple[complex, float]:
    """Return how far a foot has moved over the ground, x + iy, and up, m."""
    here, there = now.of(side), before.of(side)
    return here.point - there.point, here.height - there.height

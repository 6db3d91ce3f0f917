"""Whether the support foot of a quick step tips over an edge of its sole."""

from __future__ import annotations

import math

from wbc.gait import SWING, GaitState
from wbc.walking.stabilizer.support_polygon import SupportPolygon

_ZMP_BEYOND = 0.045  # share of the CoM's height by which the wanted ZMP is beyond the edge
_HEEL_OFF = 0.2  # share of the swing, at its end, in which the heel is free in fast walking
_TOWARDS_TOE = 0.3  # share of the way from the sole's centre to its toe from which on it does


def edge_to_tip_over(
    state: GaitState, zmp: complex, support: SupportPolygon, beyond: float
) -> complex:
    """Return the edge over which the support foot is to tip, see `GaitState.tipping`; 0: none.

    Once the DCM is beyond an edge of the sole, the pressure belongs at that edge until the other
    foot has landed. A foot that is held flat adds nothing, and only lets the leg lean as far as
    the ankle bends (15° of roll on G1): then the trunk turns in place of the leg. A foot that tips
    lets the leg lean on.

    Only in a swing that catches a push, any other robot brings its DCM back; and at the end of
    swings in fast walking, once the pressure is on its way to the toe: there the DCM is ahead of
    its plan, and the ankle of the leg that is left behind need not keep the foot flat exactly.

    Args:
        state: phase, support foot and DCM.
        zmp: ZMP that the DCM error asks for, not clamped to the sole, m.
        support: the support polygon.
        beyond: how far the DCM is beyond an edge over which a foot tips that catches a push, share
            of the CoM's height.
    """
    if state.phase is not SWING:
        return 0j
    if not state.is_quick:
        walks_fast = state.fast_share > 0.0
        return 1 + 0j if walks_fast and _frees_heel(state, zmp, support) else 0j
    height, stance = state.gait.com_height, state.stance
    wanted, dcm = stance.to_local(zmp), stance.to_local(state.dcm)
    along, across = support.zmp_range(state.support, 1.0)
    if _is_beyond(wanted.imag, dcm.imag, across, height, beyond):
        return complex(0.0, math.copysign(1.0, dcm.imag))
    if _is_beyond(wanted.real, dcm.real, along, height, beyond):
        return complex(math.copysign(1.0, dcm.real), 0.0)
    return 0j


def _frees_heel(state: GaitState, zmp: complex, support: SupportPolygon) -> bool:
    if state.progress <= 1.0 - _HEEL_OFF * state.fast_share:
        return False
    toe, _ = support.zmp_range(state.support, 1.0)
    return state.stance.to_local(zmp).real > _TOWARDS_TOE * toe


def _is_beyond(zmp: float, dcm: float, edge: float, height: float, beyond: float) -> bool:
    zmp_beyond = math.copysign(zmp, zmp * dcm) - edge
    return zmp_beyond > _ZMP_BEYOND * height and abs(dcm) - edge > beyond * height

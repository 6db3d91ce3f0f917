"""Which foot carries a robot that is pushed while its weight moves from one foot to the other."""

from __future__ import annotations

import math

from wbc.gait import GaitState, Placement
from wbc.gait.footsteps import clamp_footstep, other_side
from wbc.walking.stabilizer.disturbance import dcm_ahead
from wbc.walking.stabilizer.support_polygon import SupportPolygon

_LOOKAHEAD = 0.05  # s for which the push is taken to last on
_WORTHWHILE = 0.05  # share of the CoM height by which the other foot has to be better


def has_to_return(state: GaitState, support: SupportPolygon) -> bool:
    """Return whether the weight has to go back to the foot that it comes from.

    A robot that walks forward and is pushed back while its weight moves to the front foot has its
    DCM at the rear one soon. The ZMP at the front heel would drive the DCM on by most of a step;
    on the rear foot the ankle nearly holds it, and the front foot steps back.

    Args:
        state: during a transfer between steps.
        support: the support polygon.
    """
    error_here = _error_after_step(state, state.support, support)
    error_there = _error_after_step(state, state.swing_side, support)
    return error_there < error_here - _WORTHWHILE * state.gait.com_height


def _error_after_step(state: GaitState, side: str, support: SupportPolygon) -> float:
    """Distance of the DCM from the foot that lands after a quick step, along the support sole, m.

    Linear inverted pendulum, `ξ(T) = p + (ξ − p) e^(ωT)`: the ZMP p is where it is nearest to the
    DCM on the support sole, and the other foot lands as near to the DCM as its leg reaches.

    Only along the sole: of four pushes of G1 to each side both choices survive one.

    Args:
        state: during a transfer between steps.
        side: of the foot that carries the robot in the step.
        support: the support polygon.
    """
    quick, stance = state.recovery_gait, state.feet.of(side)
    dcm = stance.to_local(dcm_ahead(state, _LOOKAHEAD))
    along, across = support.zmp_range(side, 1.0)
    zmp = complex(max(-along, min(along, dcm.real)), max(-across, min(across, dcm.imag)))
    dcm = zmp + (dcm - zmp) * math.exp(quick.omega * quick.single_support)
    wanted = Placement(stance.to_world(dcm), stance.yaw, stance.height)
    landing = clamp_footstep(stance, other_side(side), wanted, quick)
    return abs((dcm - stance.to_local(landing.point)).real)

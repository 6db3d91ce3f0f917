"""Which foot carries a robot that is pushed while its weight moves from one foot to the other."""

from __future__ import annotations

from wbc.gait import GaitState
from wbc.walking.stabilizer.disturbance import dcm_ahead
from wbc.walking.stabilizer.step_adjustment import easy_step, footstep_adjustment
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
    """Distance of the DCM from an easy step, at the end of a quick one, along the support sole, m.

    The ZMP is at the edge of the support sole that the DCM is beyond, and the other foot lands as
    near to the DCM as an easy step gets (`easy_step`).

    Only along the sole: of four pushes of G1 to each side both choices survive one.

    Args:
        state: during a transfer between steps.
        side: of the foot that carries the robot in the step.
        support: the support polygon.
    """
    quick = state.recovery_gait
    dcm = state.feet.of(side).to_local(dcm_ahead(state, _LOOKAHEAD))
    reach = support.zmp_range(side, 1.0)
    landing = footstep_adjustment(dcm, quick.omega, quick.single_support, reach)
    return max(0.0, abs(landing.real) - easy_step(quick))

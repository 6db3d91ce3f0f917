"""Which foot carries a robot that is pushed while it stands on both."""

from __future__ import annotations

import math

from wbc.gait import GaitState
from wbc.gait.footsteps import lateral_sign, other_side
from wbc.walking.stabilizer.disturbance import dcm_ahead
from wbc.walking.stabilizer.step_adjustment import easy_step, footstep_adjustment
from wbc.walking.stabilizer.support_polygon import SupportPolygon

_LOOKAHEAD = 0.05  # s for which the push is taken to last on
_WORTHWHILE = 0.05  # share of the CoM height by which the other foot has to be better
_PREVIEW = 3  # steps looked ahead to choose the foot that steps out of standing


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


def first_swing(
    state: GaitState, dcm: complex, lateral_error: float, support: SupportPolygon
) -> str:
    """Return the side of the foot that steps first out of standing: the one that catches more.

    Mirrored pushes have mirrored answers: if either foot catches it, the one that is away from the
    push's side, which bears little, steps first.

    Args:
        state: of a robot that stands on both feet.
        dcm: the DCM that counts, a ground point, m.
        lateral_error: of that DCM across the support sole, m.
        support: the support polygon.
    """
    sides = ("right", "left") if lateral_error > 0.0 else ("left", "right")
    return min(sides, key=lambda side: _lateral_error_after(state, dcm, side, support))


def _lateral_error_after(
    state: GaitState, dcm: complex, side: str, support: SupportPolygon
) -> float:
    """Lateral distance of the DCM from the last foot of some quick steps, m.

    Linear inverted pendulum, `ξ(T) = p + (ξ − p) e^(ωT)`: during a swing the ZMP p is on the
    support sole where it is nearest to the DCM, during a transfer it is in the middle between
    both ends. Each foot lands as near to the DCM as the leg reaches.

    Args:
        state: of a robot that stands on both feet.
        dcm: the DCM that counts, a ground point, m.
        side: of the foot that takes the first step.
        support: the support polygon.
    """
    quick, stance = state.recovery_gait, state.stance
    half_width = support.zmp_range(side, 1.0)[1]
    swing, transfer = (
        math.exp(quick.omega * t) for t in (quick.single_support, quick.double_support)
    )
    across = stance.to_local(dcm).imag
    foot = stance.to_local(state.feet.of(other_side(side)).point).imag
    other = stance.to_local(state.feet.of(side).point).imag
    zmp = max(min(foot, other) - half_width, min(max(foot, other) + half_width, across))
    for _ in range(_PREVIEW):
        zmp = 0.5 * (zmp + foot)
        across = zmp + (across - zmp) * transfer
        zmp = foot + max(-half_width, min(half_width, across - foot))
        across = zmp + (across - zmp) * swing
        sign = lateral_sign(side)
        foot += sign * max(quick.least_width, min(quick.greatest_width, sign * (across - foot)))
        side = other_side(side)
    return abs(across - foot)

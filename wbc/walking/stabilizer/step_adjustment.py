"""Step adjustment: where to put the foot when the ankles cannot catch the DCM."""

from __future__ import annotations

import math

from wbc.gait import DcmReference, GaitParameters, GaitState
from wbc.geometry.planar import planar_rotation

_EASY_STEP = 0.65  # share of the CoM's height


def easy_step(quick: GaitParameters) -> float:
    """Length up to which a quick step is easy to go on from, m.

    Longer ones catch more, but the foot that comes back from one has twice the way: they are not
    counted on when a choice between two ways to step has to be made.

    Args:
        quick: parameters of the quick steps.
    """
    return min(_EASY_STEP * quick.com_height, quick.max_step)


def footstep_adjustment(
    error: complex, omega: float, remaining: float, reach: tuple[float, float]
) -> complex:
    """By how much the next footstep should move, in the support sole's axes, m.

    Left alone, a DCM error e grows to e E until touchdown, `E = exp(ω t)`. The ankles can
    move the ZMP by at most m, which takes `m (E − 1)` off it. What remains,

        max(0, |e| E − m (E − 1))  on each axis,

    only the foot's place can make up for. The subtraction is also the deadband without
    which noise and bias would be multiplied by E (after Khadiv, Herzog, Moosavian and
    Righetti, Walking control based on step timing adaptation, T-RO 2020).

    Args:
        error: ξ − ξ_ref against the plan without any shift, support sole's axes, m.
        omega: natural frequency, 1/s.
        remaining: time to touchdown t, s.
        reach: m, how far the ZMP may move from its plan along the sole and across it, m.
    """
    growth = math.exp(omega * remaining)
    along = abs(error.real) * growth - reach[0] * (growth - 1.0)
    across = abs(error.imag) * growth - reach[1] * (growth - 1.0)
    if along <= 0.0 and across <= 0.0:
        return 0j
    return complex(
        math.copysign(max(0.0, along), error.real), math.copysign(max(0.0, across), error.imag)
    )


def uncaught_dcm_error(
    state: GaitState,
    planned: DcmReference,
    reach: tuple[float, float],
    dcm: complex | None = None,
) -> complex:
    """`footstep_adjustment` of a DCM error at the end of the phase, m.

    Args:
        state: phase, feet and DCM.
        planned: DCM without any adjustment.
        reach: how far the ZMP may move from its plan along the support sole and across it, m.
        dcm: in place of the present one, m.
    """
    dcm = state.dcm if dcm is None else dcm
    error, omega, remaining = dcm - planned.dcm, state.gait.omega, state.remaining
    # Most errors are small. Since E ≥ 1 + ω t, the ankles take at least m ω t / (1 + ω t).
    growth = omega * remaining
    if abs(error) * (1.0 + growth) <= min(reach) * growth:
        return 0j
    local = error * planar_rotation(-state.stance.yaw)
    return footstep_adjustment(local, omega, remaining, reach)

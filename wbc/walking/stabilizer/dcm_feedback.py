"""DCM feedback: which ZMP brings the divergent component back to its plan."""

from __future__ import annotations

from wbc.gait.planners.dcm import DcmReference


def zmp_from_dcm_error(dcm: complex, reference: DcmReference, omega: float, gain: float) -> complex:
    """The ZMP for which the DCM error decays as e^(−k t), a ground point in m.

    From ξ̇ = ω (ξ − p − δ), with the pivot off the ZMP by δ, and the wanted
    ξ̇ = ξ̇_ref − k (ξ − ξ_ref): `p = ξ − ξ̇_ref / ω + (k / ω) (ξ − ξ_ref) − δ`
    (Englsberger et al., T-RO 2015).

    Args:
        dcm: measured ξ, ground point, m.
        reference: DCM of the plan.
        omega: natural frequency, 1/s.
        gain: k, 1/s.
    """
    pivot = dcm - reference.dcm_velocity / omega + (gain / omega) * (dcm - reference.dcm)
    return pivot - reference.cmp_offset

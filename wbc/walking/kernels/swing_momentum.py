"""Effect of the swing leg's angular momentum on the DCM; see `wbc.walking.swing_momentum`."""

from __future__ import annotations

import math

from wbc.jit.compile import argument_types, kernel, subkernel


@subkernel
def _acceleration(s: float) -> float:
    """Second derivative of the quintic from 0 to 1, at rest at both ends, at 0 ≤ s ≤ 1."""
    return 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)


@subkernel
def _discounted_acceleration(s: float, duration: float, omega: float) -> float:
    """`ω ∫ a(u) e^(−ω(u − t)) du` from now to the end of a swing over a unit distance, 1/s².

    By parts: a is a cubic polynomial, whose derivatives at the end are 0, 60, 360 and 720.

    Args:
        s: elapsed share of the swing, 0 to 1.
        duration: of the swing, s.
        omega: natural frequency ω, 1/s.
    """
    x = omega * duration
    here = (
        _acceleration(s) + (60.0 - 360.0 * s * (1.0 - s) + (720.0 * s - 360.0 + 720.0 / x) / x) / x
    )
    end = (60.0 + (360.0 + 720.0 / x) / x) / x
    return (here - math.exp(-x * (1.0 - s)) * end) / (duration * duration)


@kernel(argument_types(*(1.0,) * 7, 0j, 0j))
def swing_acceleration(
    time: float,
    duration: float,
    gap: float,
    single_support: float,
    lift: float,
    omega: float,
    kappa: float,
    distance: complex,
    further: complex,
) -> tuple[complex, complex]:
    """Return offset of the DCM and of the pivot by the present swing and the next one, m.

    Args:
        time: since the phase began, s.
        duration: of the phase, s.
        gap: time between the end of this phase and the next swing, s.
        single_support: duration of the next swing, s.
        lift: share of a swing at its beginning in which the foot goes straight up.
        omega: natural frequency ω, 1/s.
        kappa: κ, s².
        distance: way of the foot in the present swing; 0 in a transfer, m.
        further: way of the foot in the next swing; 0 if there is none, m.
    """
    offset = acceleration = 0j
    remaining = max(duration - time, 0.0)
    if distance != 0j:
        moving = (1.0 - lift) * duration
        lifting = max(lift * duration - time, 0.0)
        s = 1.0 - min(remaining / moving, 1.0)
        offset = distance * (
            math.exp(-omega * lifting) * _discounted_acceleration(s, moving, omega)
        )
        acceleration = distance * (_acceleration(s) / (moving * moving))
    if further != 0j:
        wait = remaining + gap + lift * single_support
        moving = (1.0 - lift) * single_support
        offset += further * (math.exp(-omega * wait) * _discounted_acceleration(0.0, moving, omega))
    return -kappa * offset, -kappa * acceleration

"""Quintic polynomials: the minimum-jerk motion between two states of a coordinate.

In normalised time s = t / T a coordinate is `x(s) = Σ cₖ sᵏ`, k = 0 … 5. Six coefficients meet
position, velocity and acceleration at both ends (Flash and Hogan, The coordination of arm
movements, Journal of Neuroscience 1985). Coordinates may be numbers, complex numbers (points of
the ground) or arrays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

#: Largest acceleration of a quintic from rest to rest, times T² over the distance.
PEAK_ACCELERATION = 10.0 / math.sqrt(3.0)


def quintic_coefficients(
    x0: Any, v0: Any, a0: Any, x1: Any, v1: Any = 0.0, a1: Any = 0.0
) -> tuple[Any, Any, Any, Any, Any, Any]:
    """Return the coefficients (c₀, …, c₅) of the quintic between two states.

    Args:
        x0: position at s = 0.
        v0: dx/ds at s = 0: the velocity times T.
        a0: d²x/ds² at s = 0: the acceleration times T².
        x1: position at s = 1.
        v1: dx/ds at s = 1.
        a1: d²x/ds² at s = 1.
    """
    d = x1 - x0
    return (
        x0,
        v0,
        0.5 * a0,
        10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1,
        -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1,
        6.0 * d - 3.0 * (v0 + v1) - 0.5 * a0 + 0.5 * a1,
    )


def evaluate_quintic(c: Sequence[Any], s: float | np.ndarray) -> tuple[Any, Any, Any]:
    """Return the value and the first two derivatives with respect to s of coefficients c."""
    x = c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))))
    v = c[1] + s * (2.0 * c[2] + s * (3.0 * c[3] + s * (4.0 * c[4] + s * 5.0 * c[5])))
    a = 2.0 * c[2] + s * (6.0 * c[3] + s * (12.0 * c[4] + s * 20.0 * c[5]))
    return x, v, a

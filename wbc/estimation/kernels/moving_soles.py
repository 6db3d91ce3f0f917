"""Soles that do not stand still: those that seem to move, and those that tip over an edge."""

from __future__ import annotations

import numpy as np

from wbc.estimation.kernels.filter_record import FEET, FOOT_POSITION, filter_type
from wbc.estimation.kernels.inekf import find_offset
from wbc.estimation.kernels.rotation import multiply, skew
from wbc.jit.compile import argument_types, kernel, subkernel


@subkernel
def seems_to_move(f: np.ndarray, h: np.ndarray, slip: np.ndarray) -> bool:
    """Return whether a correction that is not due yet should not wait.

    Args:
        f: the filter.
        h: (feet, 3) sole centres in IMU axes, m.
        slip: (feet,) a factor on its drift; 0 for a foot in the air.
    """
    if f["pending"] < f["early"]:
        return False
    off, least = f["b"], f["moved"] * f["moved"]
    for foot in range(h.shape[0]):
        if slip[foot] > 0.0:
            find_offset(f, foot, h[foot], off)
            if off[0] * off[0] + off[1] * off[1] + off[2] * off[2] > least:
                return True
    return False


@kernel(*(argument_types(np.zeros(1, filter_type(n)), 0, 0.0, 0.0, 0.0, 0.0) for n in FEET))
def tip(filter_: np.ndarray, foot: int, x: float, y: float, about_x: float, about_y: float) -> None:
    """Add to the covariance that a sole may have turned about the point where its pressure is.

    A rotation δ about a point that is r off the centre moves the centre by `r × δ`.

    Args:
        filter_: (1,) the filter.
        foot: index of the sole.
        x: of the point, sole axes, m.
        y: of the point, sole axes, m.
        about_x: variance of the rotation about the sole's x axis, rad².
        about_y: the same about its y axis.
    """
    f = filter_[0]
    P, F, r, cross = f["P"], f["F"][foot], f["a"], f["A"]
    turn, both = f["B"], f["C"]
    for i in range(3):
        r[i] = F[i, 0] * x + F[i, 1] * y
        for j in range(3):
            turn[i, j] = about_x * F[i, 0] * F[j, 0] + about_y * F[i, 1] * F[j, 1]
    skew(r, cross)
    multiply(cross, turn, both)
    place = FOOT_POSITION + 3 * foot
    rotation = place + 3 * f["F"].shape[0]
    for i in range(3):
        for j in range(3):
            P[rotation + i, rotation + j] += turn[i, j]
            P[place + i, rotation + j] += both[i, j]
            P[rotation + j, place + i] += both[i, j]
            for k in range(3):
                P[place + i, place + j] += both[i, k] * cross[j, k]

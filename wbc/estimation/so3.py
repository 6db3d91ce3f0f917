"""Small rotations in numpy, without the cost of a general library call."""

from __future__ import annotations

import math

import numpy as np


def skew(a: np.ndarray, out: np.ndarray) -> None:
    """Write the (3, 3) matrix of `a ×` into `out`; its diagonal is left alone."""
    x, y, z = a.tolist()
    out[0, 1] = -z
    out[0, 2] = y
    out[1, 0] = z
    out[1, 2] = -x
    out[2, 0] = -y
    out[2, 1] = x


def skews(a: np.ndarray, out: np.ndarray) -> None:
    """Write the (k, 3, 3) matrices of `a ×`, a being (k, 3), into `out`; see `skew`."""
    x, y, z = a.T
    out[:, 0, 2] = y
    out[:, 1, 0] = z
    out[:, 2, 1] = x
    np.negative(z, out=out[:, 0, 1])
    np.negative(x, out=out[:, 1, 2])
    np.negative(y, out=out[:, 2, 0])


def vee(R: np.ndarray) -> np.ndarray:
    """(k, 3) sine times axis of the rotations R (k, 3, 3)."""
    return np.array(
        [
            [0.5 * (h - f), 0.5 * (c - g), 0.5 * (d - b)]
            for (_, b, c), (d, _, f), (g, h, _) in R.tolist()
        ]
    )


def exp(a: np.ndarray) -> np.ndarray:
    """(3, 3) rotation by the vector `a`, rad (Rodrigues)."""
    vector = a.tolist()
    return np.array(_rows(vector, *_sinc_terms(vector)))


def exp_and_integral(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(exp(a), ∫₀¹ exp(s·a) ds): Γ₀ and Γ₁ of the group of double direct isometries."""
    vector = a.tolist()
    first, second = _sinc_terms(vector)
    square = sum(x * x for x in vector)
    third = (1.0 - first) / square if square > 1e-4 else (1.0 - square / 20.0) / 6.0
    return np.array(_rows(vector, first, second)), np.array(_rows(vector, second, third))


def exps(a: np.ndarray) -> np.ndarray:
    """(k, 3, 3) rotations by the vectors `a` (k, 3), rad."""
    return np.array([_rows(v, *_sinc_terms(v)) for v in a.tolist()])


def quaternion(R: np.ndarray) -> tuple[float, float, float, float]:
    """(x, y, z, w) of a rotation matrix, of unit length, w ≥ 0 (Shepperd)."""
    (a, b, c), (d, e, f), (g, h, i) = R.tolist()
    trace = a + e + i
    if trace > max(a, e, i):
        q = [h - f, c - g, d - b, 1.0 + trace]
    elif a >= e and a >= i:
        q = [1.0 + a - e - i, b + d, c + g, h - f]
    elif e >= i:
        q = [b + d, 1.0 - a + e - i, f + h, c - g]
    else:
        q = [c + g, f + h, 1.0 - a - e + i, d - b]
    scale = math.copysign(1.0 / math.sqrt(sum(x * x for x in q)), q[3])
    return q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale


def _sinc_terms(a: list[float]) -> tuple[float, float]:
    """sin(θ)/θ and (1 − cos θ)/θ²."""
    square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    if square < 1e-6:
        return 1.0 - square / 6.0, 0.5 - square / 24.0
    angle = math.sqrt(square)
    return math.sin(angle) / angle, (1.0 - math.cos(angle)) / square


def _rows(a: list[float], first: float, second: float) -> list[list[float]]:
    """Rows of I + first·[a]× + second·[a]×²."""
    x, y, z = a
    xx, yy, zz = x * x, y * y, z * z
    xy, xz, yz = second * x * y, second * x * z, second * y * z
    x, y, z = first * x, first * y, first * z
    return [
        [1.0 - second * (yy + zz), xy - z, xz + y],
        [xy + z, 1.0 - second * (xx + zz), yz - x],
        [xz - y, yz + x, 1.0 - second * (xx + yy)],
    ]

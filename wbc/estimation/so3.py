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


def exp(a: np.ndarray) -> np.ndarray:
    """(3, 3) rotation by the vector `a`, rad (Rodrigues)."""
    return _series(a, *_sinc_terms(a))


def exp_and_integral(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(exp(a), ∫₀¹ exp(s·a) ds): Γ₀ and Γ₁ of the group of double direct isometries."""
    first, second = _sinc_terms(a)
    square = float(a @ a)
    third = (1.0 - first) / square if square > 1e-8 else (1.0 - square / 20.0) / 6.0
    return _series(a, first, second), _series(a, second, third)


def log(R: np.ndarray) -> np.ndarray:
    """(3,) rotation vector of R, rad, for angles below π."""
    a = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = 0.5 * math.sqrt(float(a @ a))
    angle = math.atan2(sine, 0.5 * (float(R[0, 0] + R[1, 1] + R[2, 2]) - 1.0))
    scale = 0.5 * angle / sine if sine > 1e-6 else 0.5
    result: np.ndarray = scale * a
    return result


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


def _sinc_terms(a: np.ndarray) -> tuple[float, float]:
    """sin(θ)/θ and (1 − cos θ)/θ²."""
    square = float(a @ a)
    if square < 1e-8:
        return 1.0 - square / 6.0, 0.5 - square / 24.0
    angle = math.sqrt(square)
    return math.sin(angle) / angle, (1.0 - math.cos(angle)) / square


def _series(a: np.ndarray, first: float, second: float) -> np.ndarray:
    """I + first·[a]× + second·[a]×²."""
    x, y, z = a.tolist()
    xx, yy, zz = x * x, y * y, z * z
    xy, xz, yz = second * x * y, second * x * z, second * y * z
    x, y, z = first * x, first * y, first * z
    return np.array(
        [
            [1.0 - second * (yy + zz), xy - z, xz + y],
            [xy + z, 1.0 - second * (xx + zz), yz - x],
            [xz - y, yz + x, 1.0 - second * (xx + yy)],
        ]
    )

"""Rotations: products, exponential map, its Jacobian, quaternions."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import subkernel, subkernel_or

#: Below this angle series replace quotients of small numbers, rad.
_SMALL = 1e-3


@subkernel_or(lambda A, out: np.copyto(out, A))
def copy(A: np.ndarray, out: np.ndarray) -> None:
    """`out = A`, (3, 3)."""
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, j]


@subkernel_or(lambda A, B, out: np.copyto(out, A.dot(B)))
def multiply(A: np.ndarray, B: np.ndarray, out: np.ndarray) -> None:
    """`out = A B`, all (3, 3); `out` is neither A nor B."""
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@subkernel_or(lambda R, x, out: np.copyto(out, R.dot(x)))
def rotate(R: np.ndarray, x: np.ndarray, out: np.ndarray) -> None:
    """`out = R x`; `out` is not x."""
    for i in range(3):
        out[i] = R[i, 0] * x[0] + R[i, 1] * x[1] + R[i, 2] * x[2]


@subkernel_or(lambda R, x, out: np.copyto(out, x.dot(R)))
def rotate_back(R: np.ndarray, x: np.ndarray, out: np.ndarray) -> None:
    """`out = Rᵀ x`; `out` is not x."""
    for i in range(3):
        out[i] = R[0, i] * x[0] + R[1, i] * x[1] + R[2, i] * x[2]


@subkernel
def cross(a: np.ndarray, b: np.ndarray, out: np.ndarray) -> None:
    """`out = a × b`; `out` is neither a nor b."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@subkernel
def skew(a: np.ndarray, out: np.ndarray) -> None:
    """`out = [a ×]`, (3, 3)."""
    out[0, 0] = out[1, 1] = out[2, 2] = 0.0
    out[0, 1], out[0, 2] = -a[2], a[1]
    out[1, 0], out[1, 2] = a[2], -a[0]
    out[2, 0], out[2, 1] = -a[1], a[0]


@subkernel
def _polynomial(a: np.ndarray, first: float, second: float, out: np.ndarray) -> None:
    """`out = 1 + first [a ×] + second [a ×]²`."""
    for i in range(3):
        for j in range(3):
            out[i, j] = second * a[i] * a[j]
    diagonal = 1.0 - second * (a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    for i in range(3):
        out[i, i] += diagonal
    out[0, 1] -= first * a[2]
    out[0, 2] += first * a[1]
    out[1, 0] += first * a[2]
    out[1, 2] -= first * a[0]
    out[2, 0] -= first * a[1]
    out[2, 1] += first * a[0]


@subkernel
def exponential(a: np.ndarray, out: np.ndarray) -> None:
    """`out = exp([a ×])`, Rodrigues' formula, for a rotation vector (3,), rad."""
    square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    angle = math.sqrt(square)
    if angle < _SMALL:
        first = 1.0 - square / 6.0 * (1.0 - square / 20.0)
        second = 0.5 - square / 24.0 * (1.0 - square / 30.0)
    else:
        first = math.sin(angle) / angle
        second = (1.0 - math.cos(angle)) / square
    _polynomial(a, first, second, out)


@subkernel
def left_jacobian(a: np.ndarray, out: np.ndarray) -> None:
    """`out = ∫₀¹ exp(s [a ×]) ds`, for a rotation vector (3,), rad."""
    square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    angle = math.sqrt(square)
    if angle < _SMALL:
        first = 0.5 - square / 24.0 * (1.0 - square / 30.0)
        second = 1.0 / 6.0 - square / 120.0 * (1.0 - square / 42.0)
    else:
        first = (1.0 - math.cos(angle)) / square
        second = (angle - math.sin(angle)) / (square * angle)
    _polynomial(a, first, second, out)


@subkernel
def quaternion(R: np.ndarray, out: np.ndarray) -> None:
    """Unit quaternion (x, y, z, w) of a rotation matrix, w not negative (Shepperd's method)."""
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    if trace > 0.0:
        t = math.sqrt(trace + 1.0)
        out[3] = 0.5 * t
        t = 0.5 / t
        out[0] = (R[2, 1] - R[1, 2]) * t
        out[1] = (R[0, 2] - R[2, 0]) * t
        out[2] = (R[1, 0] - R[0, 1]) * t
    else:
        i = 0
        if R[1, 1] > R[0, 0]:
            i = 1
        if R[2, 2] > R[i, i]:
            i = 2
        j = (i + 1) % 3
        k = (j + 1) % 3
        t = math.sqrt(R[i, i] - R[j, j] - R[k, k] + 1.0)
        out[i] = 0.5 * t
        t = 0.5 / t
        out[3] = (R[k, j] - R[j, k]) * t
        out[j] = (R[j, i] + R[i, j]) * t
        out[k] = (R[k, i] + R[i, k]) * t
    if out[3] < 0.0:
        for i in range(4):
            out[i] = -out[i]

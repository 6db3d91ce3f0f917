"""Operations on matrices of the filter's size."""

from __future__ import annotations

import math

import numpy as np

from wbc.estimation.kernels.rotation import skew
from wbc.jit.compile import subkernel_or


def _combine(
    A: np.ndarray, B: np.ndarray, C: np.ndarray, b: float, c: float, out: np.ndarray
) -> None:
    out[:] = A + b * B + c * C


@subkernel_or(_combine)
def combine(
    A: np.ndarray, B: np.ndarray, C: np.ndarray, b: float, c: float, out: np.ndarray
) -> None:
    """`out = A + b B + c C`, all (3, 3)."""
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, j] + b * B[i, j] + c * C[i, j]


def _conjugate(R: np.ndarray, C: np.ndarray, out: np.ndarray, work: np.ndarray) -> None:
    out[:] = R.dot(C).dot(R.T)


@subkernel_or(_conjugate)
def conjugate(R: np.ndarray, C: np.ndarray, out: np.ndarray, work: np.ndarray) -> None:
    """`out = R C Rᵀ`, all (3, 3); `work` is a (3, 3) workspace."""
    for i in range(3):
        for j in range(3):
            work[i, j] = R[i, 0] * C[0, j] + R[i, 1] * C[1, j] + R[i, 2] * C[2, j]
    for i in range(3):
        for j in range(3):
            out[i, j] = work[i, 0] * R[j, 0] + work[i, 1] * R[j, 1] + work[i, 2] * R[j, 2]


def _subtract(A: np.ndarray, B: np.ndarray) -> None:
    A -= B


@subkernel_or(_subtract)
def subtract(A: np.ndarray, B: np.ndarray) -> None:
    """`A ← A − B`."""
    for i in range(A.shape[0]):
        for j in range(A.shape[1]):
            A[i, j] -= B[i, j]


def _add(A: np.ndarray, B: np.ndarray) -> None:
    A += B


@subkernel_or(_add)
def add(A: np.ndarray, B: np.ndarray) -> None:
    """`A ← A + B`."""
    for i in range(A.shape[0]):
        for j in range(A.shape[1]):
            A[i, j] += B[i, j]


def _difference(P: np.ndarray, first: int, second: int, out: np.ndarray) -> None:
    out[:] = P[first : first + 3] - P[second : second + 3]


@subkernel_or(_difference)
def difference(P: np.ndarray, first: int, second: int, out: np.ndarray) -> None:
    """`out = P[first : first + 3] − P[second : second + 3]`."""
    for i in range(3):
        for j in range(P.shape[1]):
            out[i, j] = P[first + i, j] - P[second + i, j]


def _difference_of_columns(A: np.ndarray, first: int, second: int, out: np.ndarray) -> None:
    out[:] = A[:, first : first + 3] - A[:, second : second + 3]


@subkernel_or(_difference_of_columns)
def difference_of_columns(A: np.ndarray, first: int, second: int, out: np.ndarray) -> None:
    """`out = A[:, first : first + 3] − A[:, second : second + 3]`."""
    for i in range(A.shape[0]):
        for j in range(3):
            out[i, j] = A[i, first + j] - A[i, second + j]


def _add_gram(A: np.ndarray, scale: float, L: np.ndarray) -> None:
    A[: len(L), : len(L)] += scale * L.dot(L.T)


@subkernel_or(_add_gram)
def add_gram(A: np.ndarray, scale: float, L: np.ndarray) -> None:
    """`A ← A + scale L Lᵀ` in the first rows and columns, for L (m, 3)."""
    for i in range(L.shape[0]):
        for j in range(L.shape[0]):
            A[i, j] += scale * (L[i, 0] * L[j, 0] + L[i, 1] * L[j, 1] + L[i, 2] * L[j, 2])


def _combine_rows(weights: np.ndarray, A: np.ndarray, out: np.ndarray) -> None:
    out[:] = -weights.dot(A)


@subkernel_or(_combine_rows)
def combine_rows(weights: np.ndarray, A: np.ndarray, out: np.ndarray) -> None:
    """`out = −weightsᵀ A`."""
    for j in range(A.shape[1]):
        out[j] = 0.0
    for i in range(A.shape[0]):
        for j in range(A.shape[1]):
            out[j] -= weights[i] * A[i, j]


def _invert_factor(S: np.ndarray, inverse: np.ndarray, m: int) -> None:
    inverse[:] = 0.0
    inverse[:m, :m] = np.tril(np.linalg.inv(np.linalg.cholesky(S[:m, :m])))


@subkernel_or(_invert_factor)
def invert_factor(S: np.ndarray, inverse: np.ndarray, m: int) -> None:
    """Inverse of the lower Cholesky factor of S[:m, :m], zero beyond; S is overwritten."""
    for i in range(inverse.shape[0]):
        for j in range(inverse.shape[1]):
            inverse[i, j] = 0.0
    for j in range(m):
        s = S[j, j]
        for k in range(j):
            s -= S[j, k] * S[j, k]
        S[j, j] = math.sqrt(s)
        for i in range(j + 1, m):
            s = S[i, j]
            for k in range(j):
                s -= S[i, k] * S[j, k]
            S[i, j] = s / S[j, j]
    for j in range(m):
        inverse[j, j] = 1.0 / S[j, j]
        for i in range(j + 1, m):
            s = 0.0
            for k in range(j, i):
                s -= S[i, k] * inverse[k, j]
            inverse[i, j] = s / S[i, i]


def _whiten(inverse: np.ndarray, x: np.ndarray, whitened: np.ndarray, weighted: np.ndarray) -> None:
    whitened[:] = inverse.dot(x)
    weighted[:] = whitened.dot(inverse)


@subkernel_or(_whiten)
def whiten(inverse: np.ndarray, x: np.ndarray, whitened: np.ndarray, weighted: np.ndarray) -> None:
    """`whitened = L⁻¹ x` and `weighted = L⁻ᵀ L⁻¹ x`, for the inverse of a lower factor L."""
    n = inverse.shape[0]
    for i in range(n):
        s = 0.0
        for j in range(i + 1):
            s += inverse[i, j] * x[j]
        whitened[i] = s
    for i in range(n):
        s = 0.0
        for j in range(i, n):
            s += inverse[j, i] * whitened[j]
        weighted[i] = s


def _move_errors(P: np.ndarray, way: np.ndarray, first: int, end: int) -> None:
    lever = np.empty((3, 3))
    skew(way, lever)
    for place in range(first, end, 3):
        P[place : place + 3] += lever.dot(P[:3])
    for place in range(first, end, 3):
        P[:, place : place + 3] += P[:, :3].dot(lever.T)


@subkernel_or(_move_errors)
def move_errors(P: np.ndarray, way: np.ndarray, first: int, end: int) -> None:
    """`P ← T P Tᵀ`, where T adds `way × ξ_R` to each position's error from `first` to `end`."""
    x, y, z = way[0], way[1], way[2]
    for j in range(P.shape[1]):
        a = y * P[2, j] - z * P[1, j]
        b = z * P[0, j] - x * P[2, j]
        c = x * P[1, j] - y * P[0, j]
        for place in range(first, end, 3):
            P[place, j] += a
            P[place + 1, j] += b
            P[place + 2, j] += c
    for i in range(P.shape[0]):
        a = y * P[i, 2] - z * P[i, 1]
        b = z * P[i, 0] - x * P[i, 2]
        c = x * P[i, 1] - y * P[i, 0]
        for place in range(first, end, 3):
            P[i, place] += a
            P[i, place + 1] += b
            P[i, place + 2] += c

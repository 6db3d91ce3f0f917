"""Triangular factors of small matrices. Their diagonals hold reciprocals."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import subkernel

_INDEPENDENT = 1e-11  # least share of a row that the rows before it do not span


@subkernel
def cholesky(H: np.ndarray, L: np.ndarray) -> bool:
    """Lower L of H = L Lᵀ, with reciprocal diagonal; False unless H is positive definite.

    Two rows and two columns at a time, which halves the loads.
    """
    n = H.shape[0]
    for i in range(0, n, 2):
        paired = i + 1 < n
        i2 = i + 1 if paired else i
        for j in range(0, i, 2):
            a, b, c, d = H[i, j], H[i, j + 1], H[i2, j], H[i2, j + 1]
            for k in range(j):
                x, y, u, w = L[i, k], L[i2, k], L[j, k], L[j + 1, k]
                a -= x * u
                b -= x * w
                c -= y * u
                d -= y * w
            p, q, r = L[j, j], L[j + 1, j], L[j + 1, j + 1]
            a *= p
            L[i, j], L[i, j + 1] = a, (b - a * q) * r
            if paired:
                c *= p
                L[i2, j], L[i2, j + 1] = c, (d - c * q) * r
        a, b, c = H[i, i], H[i2, i], H[i2, i2]
        for k in range(i):
            x, y = L[i, k], L[i2, k]
            a -= x * x
            b -= x * y
            c -= y * y
        if not a > 1e-14 * H[i, i]:
            return False
        a = 1.0 / math.sqrt(a)
        L[i, i] = a
        if paired:
            b *= a
            c -= b * b
            if not c > 1e-14 * H[i2, i2]:
                return False
            L[i2, i], L[i2, i2] = b, 1.0 / math.sqrt(c)
    return True


@subkernel
def solve_lower(L: np.ndarray, b: np.ndarray, first: int | np.int64) -> None:
    """b ← L⁻¹ b, whose entries before `first` are zero."""
    for i in range(first, b.size):
        s = b[i]
        for k in range(first, i):
            s -= L[i, k] * b[k]
        b[i] = s * L[i, i]


@subkernel
def solve_lower_transposed(L: np.ndarray, b: np.ndarray, n: int) -> None:
    """b[:n] ← L⁻ᵀ b[:n]."""
    for i in range(n - 1, -1, -1):
        s = b[i] * L[i, i]
        b[i] = s
        for k in range(i):
            b[k] -= L[i, k] * s


@subkernel
def factor_row(K: np.ndarray, F: np.ndarray, i: int) -> bool:
    """Row i of the lower factor F of K, reciprocal diagonal; False when K's row is dependent.

    A dependent row gets a zero there, which makes its multiplier zero.
    """
    for j in range(i):
        s = K[i, j]
        for k in range(j):
            s -= F[i, k] * F[j, k]
        F[i, j] = s * F[j, j]
    s = K[i, i]
    for k in range(i):
        s -= F[i, k] * F[i, k]
    F[i, i] = 0.0
    if not s > _INDEPENDENT * K[i, i]:
        return False
    F[i, i] = 1.0 / math.sqrt(s)
    return True


@subkernel
def solve_factored(F: np.ndarray, b: np.ndarray, k: int) -> None:
    """b[:k] ← (F Fᵀ)⁻¹ b[:k]."""
    for i in range(k):
        s = b[i]
        for j in range(i):
            s -= F[i, j] * b[j]
        b[i] = s * F[i, i]
    solve_lower_transposed(F, b, k)

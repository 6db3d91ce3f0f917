"""Triangular factors of small matrices. Their diagonals hold reciprocals."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import subkernel

_INDEPENDENT = 1e-11  # least share of a row that the rows before it do not span


@subkernel
def cholesky(H: np.ndarray, U: np.ndarray) -> bool:
    """Upper U of H = Uᵀ U row by row, with reciprocal diagonal; False unless positive definite.

    Rows are combined by fours: it is the loads and stores that cost.
    """
    n = H.shape[0]
    for i in range(n):
        row = U[i]
        for j in range(i, n):
            row[j] = H[i, j]
        k = 0
        while k + 4 <= i:
            f0, f1, f2, f3 = U[k, i], U[k + 1, i], U[k + 2, i], U[k + 3, i]
            for j in range(i, n):
                row[j] -= (f0 * U[k, j] + f1 * U[k + 1, j]) + (f2 * U[k + 2, j] + f3 * U[k + 3, j])
            k += 4
        while k < i:
            f0 = U[k, i]
            for j in range(i, n):
                row[j] -= f0 * U[k, j]
            k += 1
        s = row[i]
        if not s > 1e-14 * H[i, i]:
            return False
        reciprocal = 1.0 / math.sqrt(s)
        for j in range(i + 1, n):
            row[j] *= reciprocal
        row[i] = reciprocal
    return True


@subkernel
def solve_transposed(U: np.ndarray, b: np.ndarray, first: int | np.int64) -> None:
    """b ← U⁻ᵀ b, whose entries before `first` are zero."""
    n = b.size
    for i in range(first, n):
        s = b[i] * U[i, i]
        b[i] = s
        for j in range(i + 1, n):
            b[j] -= s * U[i, j]


@subkernel
def solve_upper(U: np.ndarray, b: np.ndarray) -> None:
    """b ← U⁻¹ b."""
    n = b.size
    for i in range(n - 1, -1, -1):
        s = b[i]
        for j in range(i + 1, n):
            s -= U[i, j] * b[j]
        b[i] = s * U[i, i]


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
    for i in range(k - 1, -1, -1):
        s = b[i] * F[i, i]
        b[i] = s
        for j in range(i):
            b[j] -= F[i, j] * s

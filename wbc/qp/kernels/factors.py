"""Triangular factors of small matrices. Their diagonals hold reciprocals."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import subkernel

_INDEPENDENT = 1e-11  # least share of a row that the rows before it do not span


@subkernel
def cholesky(H: np.ndarray, L: np.ndarray) -> bool:
    """L of H = L Lᵀ row by row, with reciprocal diagonal; False unless positive definite."""
    n = H.shape[0]
    for i in range(n):
        for j in range(i):
            s = H[i, j]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = s * L[j, j]
        s = H[i, i]
        for k in range(i):
            s -= L[i, k] * L[i, k]
        if not s > 1e-14 * H[i, i]:
            return False
        L[i, i] = 1.0 / math.sqrt(s)
    return True


@subkernel
def forward(L: np.ndarray, b: np.ndarray, first: int | np.int64) -> None:
    """b ← L⁻¹ b, whose entries before `first` are zero."""
    for i in range(first, b.size):
        s = b[i]
        for k in range(first, i):
            s -= L[i, k] * b[k]
        b[i] = s * L[i, i]


@subkernel
def backward(L: np.ndarray, b: np.ndarray, n: int) -> None:
    """b[:n] ← L⁻ᵀ b[:n]."""
    for i in range(n - 1, -1, -1):
        s = b[i] * L[i, i]
        b[i] = s
        for k in range(i):
            b[k] -= L[i, k] * s


@subkernel
def factor_row(K: np.ndarray, F: np.ndarray, i: int) -> bool:
    """Row i of the factor F of K, reciprocal diagonal; False when K's row is dependent.

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
    backward(F, b, k)

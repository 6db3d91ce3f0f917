"""Base acceleration, contact forces and torques as affine maps of the unknowns.

The kernel of `wbc.qp.elimination`, which explains the maps.
"""

from __future__ import annotations

import math

import numpy as np

from wbc.qp.kernels.groups import Maps, Rows
from wbc.qp.kernels.jit import part


@part
def invert_action(X: np.ndarray, out: np.ndarray) -> None:
    """`[R, S; 0, R]⁻¹ = [Rᵀ, −Rᵀ S Rᵀ; 0, Rᵀ]`."""
    out[3:, :3] = 0.0
    for i in range(3):
        for j in range(3):
            out[i, j] = out[3 + i, 3 + j] = X[j, i]
    for i in range(3):
        for j in range(3):
            s = 0.0
            for k in range(3):
                for m in range(3):
                    s -= X[k, i] * X[k, 3 + m] * X[j, m]
            out[i, 3 + j] = s


@part
def eliminate(
    maps: Maps, M: np.ndarray, h: np.ndarray, J: np.ndarray, a: np.ndarray, unit: float
) -> None:
    """B, W, T of the elimination, see `wbc.qp.elimination`."""
    B, W, T, S, stance = maps.B, maps.W, maps.T, maps.S, maps.stance
    nv, nf = M.shape[0], J.shape[0]
    na, last = nv - 6, B.shape[1] - 1
    gone = 6 if stance.size > 0 else 0  # force components that are not unknowns
    X = np.empty((6, 6))
    if gone:
        invert_action(J[:6, :6], X)
        for i in range(6):
            for c in stance:
                s = 0.0
                for k in range(6):
                    s -= X[i, k] * J[k, 6 + c]
                B[i, c] = s
            s = 0.0
            for k in range(6):
                s += X[i, k] * a[k]
            B[i, last] = s
    # S: forces on the base at v̇_base = 0.
    for i in range(6):
        for c in range(na):
            S[i, c] = M[i, 6 + c]
        for f in range(gone, nf):
            S[i, na + f - gone] = -unit * J[f, i]
        S[i, last] = h[i]
    if not gone:
        solve_base(M, S, B)
    # With the base's motion. Without a stance contact S becomes zero: the base is free.
    for i in range(6):
        for k in range(6):
            m = M[i, k]
            for c in maps.dense:
                S[i, c] += m * B[k, c]
    for j in range(na):
        out = T[j]
        for c in range(na):
            out[c] = M[6 + j, 6 + c]
        for f in range(gone, nf):
            out[na + f - gone] = -unit * J[f, 6 + j]
        out[last] = h[6 + j]
        for k in range(6):
            m = M[6 + j, k]
            for c in maps.dense:
                out[c] += m * B[k, c]
    for j in stance:
        for k in range(6):
            p = B[k, j]
            for c in range(last + 1):
                T[j, c] += p * S[k, c]
    for i in range(gone):
        W[i, :] = 0.0
        for k in range(6):
            x = X[k, i]
            for c in range(last + 1):
                W[i, c] += x * S[k, c]


@part
def solve_base(M: np.ndarray, S: np.ndarray, B: np.ndarray) -> None:
    """B = −M_bb⁻¹ S."""
    L = np.empty((6, 6))
    for i in range(6):
        for j in range(i + 1):
            s = M[i, j]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = math.sqrt(s) if i == j else s / L[j, j]
    for i in range(6):
        B[i] = -S[i]
        for k in range(i):
            B[i] -= L[i, k] * B[k]
        B[i] /= L[i, i]
    for i in range(5, -1, -1):
        for k in range(i + 1, 6):
            B[i] -= L[k, i] * B[k]
        B[i] /= L[i, i]


@part
def project(rows: Rows, row: int, maps: Maps, out: np.ndarray) -> None:
    """out ← x̂'s coefficients of `A v̇` for one row of A."""
    na = maps.T.shape[0]
    out[:] = 0.0
    for c in range(na):
        out[c] = rows.A[row, 6 + c]
    for k in range(6):
        s = rows.A[row, k]
        if s != 0.0:
            for c in maps.dense:
                out[c] += s * maps.B[k, c]

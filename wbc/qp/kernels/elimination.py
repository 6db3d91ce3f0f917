"""Base acceleration, contact forces and torques as affine maps of the unknowns.

The kernel of `wbc.qp.elimination`, which explains the maps.
"""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import subkernel
from wbc.qp.kernels.groups import AffineMaps


@subkernel
def invert_action(X: np.ndarray, out: np.ndarray) -> None:
    """`[R, S; 0, R]⁻¹ = [Rᵀ, −Rᵀ S Rᵀ; 0, Rᵀ]`."""
    for i in range(3):
        for j in range(3):
            out[i, j] = out[3 + i, 3 + j] = X[j, i]
            out[3 + i, j] = 0.0
    for i in range(3):
        for j in range(3):
            s = 0.0
            for k in range(3):
                for m in range(3):
                    s -= X[k, i] * X[k, 3 + m] * X[j, m]
            out[i, 3 + j] = s


@subkernel
def eliminate(
    maps: AffineMaps, M: np.ndarray, h: np.ndarray, J: np.ndarray, a: np.ndarray, unit: float
) -> None:
    """Compute B, W and T of the elimination, see `wbc.qp.elimination`."""
    B, W, T, S, stance = maps.B, maps.W, maps.T, maps.base_force, maps.stance_joints
    nv, nf = M.shape[0], J.shape[0]
    na, last = nv - 6, B.shape[1] - 1
    eliminated = 6 if stance.size > 0 else 0  # force components that are not unknowns
    X = np.empty((6, 6))
    if eliminated:
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
        for f in range(eliminated, nf):
            S[i, na + f - eliminated] = -unit * J[f, i]
        S[i, last] = h[i]
    if not eliminated:
        solve_base(M, S, B)
    # With the base's motion. Without a stance contact S becomes zero: the base is free.
    for i in range(6):
        add_columns(M[i], B, maps.dense_columns, S[i])
    for j in range(na):
        out = T[j]
        for c in range(na):
            out[c] = M[6 + j, 6 + c]
        for f in range(eliminated, nf):
            out[na + f - eliminated] = -unit * J[f, 6 + j]
        out[last] = h[6 + j]
        add_columns(M[6 + j], B, maps.dense_columns, out)
    weights = np.empty(6)
    for j in stance:
        for k in range(6):
            weights[k] = B[k, j]
        add_product(weights, S, T[j])
    for i in range(eliminated):
        for k in range(6):
            weights[k] = X[k, i]
        for c in range(last + 1):
            W[i, c] = 0.0
        add_product(weights, S, W[i])


@subkernel
def add_product(weights: np.ndarray, B: np.ndarray, out: np.ndarray) -> None:
    """out += Bᵀ weights for six rows B. Six products in one pass, which saves stores."""
    w0, w1, w2, w3, w4, w5 = weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]
    for c in range(out.size):
        out[c] += (w0 * B[0, c] + w1 * B[1, c] + w2 * B[2, c]) + (
            w3 * B[3, c] + w4 * B[4, c] + w5 * B[5, c]
        )


@subkernel
def add_columns(weights: np.ndarray, B: np.ndarray, columns: np.ndarray, out: np.ndarray) -> None:
    """out += Bᵀ weights for six rows B, in some columns only."""
    w0, w1, w2, w3, w4, w5 = weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]
    for c in columns:
        out[c] += (w0 * B[0, c] + w1 * B[1, c] + w2 * B[2, c]) + (
            w3 * B[3, c] + w4 * B[4, c] + w5 * B[5, c]
        )


@subkernel
def solve_base(M: np.ndarray, S: np.ndarray, B: np.ndarray) -> None:
    """B = −M_bb⁻¹ S."""
    L = np.empty((6, 6))
    for i in range(6):
        for j in range(i + 1):
            s = M[i, j]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = math.sqrt(s) if i == j else s / L[j, j]
    for c in range(B.shape[1]):
        for i in range(6):
            s = -S[i, c]
            for k in range(i):
                s -= L[i, k] * B[k, c]
            B[i, c] = s / L[i, i]
        for i in range(5, -1, -1):
            s = B[i, c]
            for k in range(i + 1, 6):
                s -= L[k, i] * B[k, c]
            B[i, c] = s / L[i, i]


@subkernel
def project(A: np.ndarray, constant: float, maps: AffineMaps, out: np.ndarray) -> None:
    """out ← x̂'s coefficients of `A v̇ + constant` for one row A."""
    na = maps.T.shape[0]
    for c in range(na):
        out[c] = A[6 + c]
    for c in range(na, out.size - 1):
        out[c] = 0.0
    out[out.size - 1] = constant
    add_columns(A, maps.B, maps.dense_columns, out)

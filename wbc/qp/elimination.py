"""Which unknowns the QP is written in, and how everything else follows from them.

All formulations express the generalised acceleration, the contact forces and the
joint torques as affine functions of the QP's unknowns x,

    v̇ = V x + v0,    f = W x + w0,    τ = T x + t0,

so that the rows of tasks, contacts and limits are assembled in one way. The dynamics
are `M v̇ + h = Sᵀ τ + Jᵀ f`; its six base rows are what the formulations remove:

- `full`: x = (v̇, f); the base rows remain as equalities. The readable reference.
- `stance`: a surface contact that moves exactly as told fixes the base,
  `J_b v̇_b + J_a q̈_a = a`, and its wrench follows from the base rows through the same
  6×6 inverse; x = (q̈_a, other forces).
- `floating`: no such contact; `v̇_b = M_bb⁻¹ (J_bᵀ f − h_b − M_ba q̈_a)`, x = (q̈_a, f).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(slots=True)
class Elimination:
    """The affine maps, see the module's text.

    Attributes:
        V: (nv, n) and v0 (nv,): generalised acceleration.
        W: (nf, n) and w0 (nf,): contact forces, contact axes, in the contacts' order.
        T: (na, n) and t0 (na,): joint torques.
        E: (k, n) and e (k,): equalities `E x = e` that remain.
    """

    V: np.ndarray
    v0: np.ndarray
    W: np.ndarray
    w0: np.ndarray
    T: np.ndarray
    t0: np.ndarray
    E: np.ndarray
    e: np.ndarray


def full(M: np.ndarray, h: np.ndarray, J: np.ndarray) -> Elimination:
    """x = (v̇, f). M (nv, nv), h (nv,), J (nf, nv) stacked contact Jacobians."""
    nv, nf = M.shape[0], J.shape[0]
    eye = np.eye(nv + nf)
    return Elimination(
        V=eye[:nv],
        v0=np.zeros(nv),
        W=eye[nv:],
        w0=np.zeros(nf),
        T=np.hstack((M[6:], -J[:, 6:].T)),
        t0=h[6:],
        E=np.hstack((M[:6], -J[:, :6].T)),
        e=-h[:6],
    )


def floating(M: np.ndarray, h: np.ndarray, J: np.ndarray) -> Elimination:
    """x = (q̈_a, f); arguments as in `full`."""
    nv, nf = M.shape[0], J.shape[0]
    na = nv - 6
    n = na + nf
    inverse = np.linalg.inv(M[:6, :6])
    V = np.zeros((nv, n))
    V[:6, :na] = -inverse @ M[:6, 6:]
    V[:6, na:] = inverse @ J[:, :6].T
    V[6:, :na].flat[:: na + 1] = 1.0
    v0 = np.zeros(nv)
    v0[:6] = -inverse @ h[:6]
    W = np.zeros((nf, n))
    W[:, na:].flat[:: nf + 1] = 1.0
    T = M[6:] @ V
    T[:, na:] -= J[:, 6:].T
    return Elimination(
        V, v0, W, np.zeros(nf), T, M[6:] @ v0 + h[6:], np.empty((0, n)), np.empty(0)
    )


def stance(M: np.ndarray, h: np.ndarray, J: np.ndarray, a: np.ndarray) -> Elimination:
    """x = (q̈_a, forces of all contacts but the first).

    The first six rows of J (nf, nv) belong to a surface contact whose acceleration is
    exactly `J[:6] v̇ = a`; other arguments as in `full`.
    """
    nv, nf = M.shape[0], J.shape[0]
    na, nr = nv - 6, nf - 6
    n = na + nr
    inverse = np.linalg.inv(J[:6, :6])
    V = np.zeros((nv, n))
    V[:6, :na] = base = -inverse @ J[:6, 6:]
    V[6:, :na].flat[:: na + 1] = 1.0
    v0 = np.zeros(nv)
    v0[:6] = inverse @ a
    # M times the acceleration map, without the multiplications by its identity part.
    MS = M[:, 6:] + M[:, :6] @ base
    bias = M[:, :6] @ v0[:6] + h
    rest = J[6:]
    W = np.zeros((nf, n))
    W[:6, :na] = inverse.T @ MS[:6]
    W[:6, na:] = -inverse.T @ rest[:, :6].T
    W[6:, na:].flat[:: nr + 1] = 1.0
    w0 = np.zeros(nf)
    w0[:6] = inverse.T @ bias[:6]
    T = np.empty((na, n))
    T[:, :na] = MS[6:] + base.T @ MS[:6]
    T[:, na:] = -(rest[:, 6:] + rest[:, :6] @ base).T
    t0 = bias[6:] + base.T @ bias[:6]
    return Elimination(V, v0, W, w0, T, t0, np.empty((0, n)), np.empty(0))

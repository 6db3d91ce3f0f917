"""Which unknowns the QP is written in, and how everything else follows from them.

All formulations express the base's acceleration, the contact forces and the joint torques
as affine functions of the QP's unknowns x. With a one appended, x̂ = (x, 1), each of these
is a single matrix whose last column is the constant part:

    v̇_base = B x̂,    f = W x̂,    τ = T x̂,

and the joint accelerations are a run of entries of x. So the rows of tasks, contacts and
limits are assembled in one way, constants and all. The dynamics are
`M v̇ + h = Sᵀ τ + Jᵀ f`; the formulations differ in how they treat its six base rows:

- `NoElimination`: x = (v̇, f); the base rows remain as equalities E x̂ = 0. The readable reference.
- `StanceElimination`: an exact surface contact determines the motion of the base,
  `J_b v̇_base + J_a q̈ = a`, and its wrench follows from the base rows through the same
  6×6 inverse; x = (q̈, other forces).
- `BaseElimination`: no such contact; `v̇_base = M_bb⁻¹ (J_bᵀ f − h_b − M_ba q̈)`, x = (q̈, f).

Forces enter x in units of `unit` newton (newton metre): with the robot's weight for a unit
they are of the order of one, like accelerations, and H is well conditioned.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np


class Elimination(ABC):
    """The affine maps of one formulation, in arrays that `update` overwrites.

    Args:
        nv: size of the generalised velocity.
        nf: number of contact force components.
        unknowns: n, the size of x.
        joints: index of the first joint acceleration in x.
        eliminated: number of force components that are not in x; they come first.
        unit: see the module's text.

    Attributes:
        B: (6, n + 1) base acceleration, base axes.
        W: (nf, n + 1) contact forces, contact axes, in the contacts' order.
        T: (na, n + 1) joint torques.
        E: (k, n + 1) what must be zero of x̂.
        joints: part of x with the joint accelerations.
        free: part of x with the forces that are not eliminated.
    """

    def __init__(
        self, nv: int, nf: int, unknowns: int, joints: int, eliminated: int, unit: float
    ) -> None:
        na, n = nv - 6, unknowns
        self.n = n
        self.unit = unit
        self.eliminated = eliminated
        self.joints = slice(joints, joints + na)
        self.free = slice(joints + na, n)
        self.B = np.zeros((6, n + 1))
        self.W = np.zeros((nf, n + 1))
        self.T = np.zeros((na, n + 1))
        self.E = np.zeros((0, n + 1))
        for k in range(nf - eliminated):
            self.W[eliminated + k, joints + na + k] = unit

    @abstractmethod
    def update(self, M: np.ndarray, h: np.ndarray, J: np.ndarray, a: np.ndarray) -> None:
        """Recompute the maps.

        Args:
            M: (nv, nv) mass matrix.
            h: (nv,) bias forces.
            J: (nf, nv) stacked contact Jacobians, contact axes.
            a: (nf,) prescribed accelerations of the contacts, `J v̇ = a`.
        """

    def project(self, A: np.ndarray, out: np.ndarray) -> None:
        """Write `out` (k, n + 1) with `A v̇ = out x̂` for rows A (k, nv)."""
        np.matmul(A[:, :6], self.B, out=out)
        out[:, self.joints] += A[:, 6:]

    def acceleration(self, x: np.ndarray) -> np.ndarray:
        """Return the generalised acceleration (nv,) of x̂ (n + 1,)."""
        return np.concatenate((self.B @ x, x[self.joints]))


class NoElimination(Elimination):
    """x = (v̇, f)."""

    def __init__(self, nv: int, nf: int, unit: float) -> None:
        super().__init__(nv, nf, nv + nf, 6, 0, unit)
        self.B[:, :6] = np.eye(6)
        self.E = np.zeros((6, self.n + 1))

    def update(self, M: np.ndarray, h: np.ndarray, J: np.ndarray, a: np.ndarray) -> None:
        nv = M.shape[0]
        for rows, out in ((slice(0, 6), self.E), (slice(6, nv), self.T)):
            out[:, :nv] = M[rows]
            out[:, nv:-1] = -self.unit * J[:, rows].T
            out[:, -1] = h[rows]


class BaseElimination(Elimination):
    """x = (q̈, f)."""

    def __init__(self, nv: int, nf: int, unit: float) -> None:
        super().__init__(nv, nf, nv - 6 + nf, 0, 0, unit)

    def update(self, M: np.ndarray, h: np.ndarray, J: np.ndarray, a: np.ndarray) -> None:
        na = M.shape[0] - 6
        B, T = self.B, self.T
        B[:, :na] = -M[:6, 6:]
        B[:, na:-1] = self.unit * J[:, :6].T
        B[:, -1] = -h[:6]
        B[:] = np.linalg.solve(M[:6, :6], B)
        np.matmul(M[6:, :6], B, out=T)
        T[:, :na] += M[6:, 6:]
        T[:, na:-1] -= self.unit * J[:, 6:].T
        T[:, -1] += h[6:]


class StanceElimination(Elimination):
    """x = (q̈, forces of all contacts but the first).

    The first six rows of J belong to an exact surface contact. With
    X the inverse of their base columns, P = −X J_a and J' the other contacts' rows,

        v̇_base = P q̈ + X a,                   f_1 = Xᵀ (M_b v̇ + h_b − J'_bᵀ f'),
        τ = (M_a + Pᵀ M_b) v̇ + h_a + Pᵀ h_b − (J'_a + J'_b P)ᵀ f'.
    """

    def __init__(self, nv: int, nf: int, unit: float) -> None:
        super().__init__(nv, nf, nv + nf - 12, 0, 6, unit)
        na = nv - 6
        self._P = np.empty((6, na))
        self._base = np.empty((6, na + 1))  # P, and X a in the last column
        self._inertia = np.empty((nv, na + 1))  # M v̇ + h, of q̈ and one

    def update(self, M: np.ndarray, h: np.ndarray, J: np.ndarray, a: np.ndarray) -> None:
        na = M.shape[0] - 6
        base, inertia, B, W, T = self._base, self._inertia, self.B, self.W, self.T
        X = inverse_of_action(J[:6, :6])
        np.dot(X, J[:6, 6:], out=self._P)
        np.negative(self._P, out=base[:, :na])
        base[:, na] = X.dot(a[:6])
        np.matmul(M[:, :6], base, out=inertia)
        inertia[:, :na] += M[:, 6:]
        inertia[:, na] += h
        torque = base[:, :na].T.dot(inertia[:6])
        torque += inertia[6:]
        wrench = X.T.dot(inertia[:6])
        for out, joints_and_one in ((B, base), (W[:6], wrench), (T, torque)):
            out[:, :na] = joints_and_one[:, :na]
            out[:, -1] = joints_and_one[:, na]
        if W.shape[0] > 6:
            others = -self.unit * J[6:]
            W[:6, na:-1] = X.T.dot(others[:, :6].T)
            T[:, na:-1] = (others[:, 6:] + others[:, :6].dot(base[:, :na])).T


def inverse_of_action(X: np.ndarray) -> np.ndarray:
    """Return the inverse (6, 6) of the matrix by which a rigid displacement acts on twists.

    For `X = [R, S; 0, R]` it is `[Rᵀ, −Rᵀ S Rᵀ; 0, Rᵀ]`.
    """
    R = X[:3, :3]
    inverse = np.zeros((6, 6))
    inverse[:3, :3] = inverse[3:, 3:] = R.T
    inverse[:3, 3:] = R.T.dot(X[:3, 3:]).dot(R.T)
    np.negative(inverse[:3, 3:], out=inverse[:3, 3:])
    return inverse

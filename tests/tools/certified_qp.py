"""Solves the unreduced problem in extended precision and certifies the solution.

An interior-point method (PIQP) guesses which rows are active; the optimum for these rows is
computed from QR factors of the cost's and the constraints' rows (H = GᵀG is never formed), and
refined with residuals in extended precision. Rows are then exchanged until the optimality
conditions hold in extended precision. As the cost is strictly convex they prove the optimum,
wherever the guess came from; where exchanging gets nowhere, a dual active-set method (Goldfarb
and Idnani, Mathematical Programming 1983) makes another one. That there is no solution is proved
by multipliers after Farkas.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular
from scipy.optimize import linprog, nnls
from unreduced_qp import UnreducedQP

EPS = float(np.finfo(float).eps)
_LONG = np.longdouble
_RANK = 1e-10  # of rows of unit norm
_MAX_VIOLATION = 1e-13  # violation of a row of unit norm that counts as none, relative to its bound
_SIGN = 1e-16  # multiplier of the wrong sign that counts as zero, of the gradient's terms
_STEPS = 1000
_EXCHANGES = 20
_TOGETHER = 8  # exchanges of many rows in one go


@dataclass
class Optimum:
    """A certified optimum, in scaled unknowns.

    Attributes:
        x: (n,).
        active: indices of the inequality rows that are active, and on which side (±1).
        attainable: (n,) by how much rounding alone moves the optimum of a solver that is given
            H = GᵀG in double precision: a first-order bound, entry by entry.
        free: (n, k) orthonormal directions along which no active row changes.
        stationarity: what is left of the gradient, relative to its terms.
        violation: of the worst row.
    """

    x: np.ndarray
    active: dict[int, int]
    attainable: np.ndarray
    free: np.ndarray
    stationarity: float
    violation: float


@dataclass
class Infeasibility:
    """How far the rows are from being feasible, by a linear program.

    Attributes:
        violation: least possible violation of the worst row of unit norm; zero when they can
            hold together.
        radius: no point nearer to the origin than this holds all rows; proved by multipliers
            y ≥ 0 with `Aᵀ y ≈ 0` and `bᵀ y < 0`.
    """

    violation: float
    radius: float


def optimum(rows: UnreducedQP, guess: dict[int, int] | None = None) -> Optimum | None:
    """Return the certified optimum; None when none was found, see `infeasibility` then.

    Args:
        rows: the problem.
        guess: active rows to start from, those of the last tick, say.
    """
    working = _ActiveSet(rows)
    if not working.consistent:
        return None
    guesses = (lambda: guess, lambda: _active_rows_by_interior_point(rows), working.dual_active_set)
    for guessed in guesses:
        active = guessed()
        found = None if active is None else working.exchange(active)
        if found is not None:
            return found
    return None


def infeasibility(rows: UnreducedQP) -> Infeasibility:
    """Return how far the rows are from being feasible, by a linear program and its multipliers."""
    n = rows.G.shape[1]
    above, below = np.isfinite(rows.high), np.isfinite(rows.low)
    A = np.vstack((rows.E, -rows.E, rows.C[above], -rows.C[below]))
    b = np.concatenate((rows.e, -rows.e, rows.high[above], -rows.low[below]))
    elastic = np.hstack((A, -np.ones((b.size, 1))))
    cost = np.zeros(n + 1)
    cost[-1] = 1.0
    free = [(None, None)] * n + [(0.0, None)]
    found = linprog(cost, A_ub=elastic, b_ub=b, bounds=free, method="highs")
    if found.status != 0:
        raise RuntimeError(f"the linear program found no answer: {found.message}")
    y = np.maximum(-found.ineqlin.marginals, 0.0)
    support = np.flatnonzero(y > 1e-9 * y.max(initial=0.0))
    if found.fun <= 0.0 or not support.size:
        return Infeasibility(0.0, 0.0)
    # HiGHS' multipliers hold to 1e-9 or so: of the rows that they pick, ones that hold to rounding.
    S = A[support]
    y, _ = nnls(np.column_stack((S, b[support])).T, np.append(np.zeros(n), -1.0))
    left = np.linalg.norm(S.T.astype(_LONG) @ y)
    gap = -float(b[support].astype(_LONG) @ y)
    return Infeasibility(float(found.fun), gap / max(float(left), 1e-300) if gap > 0.0 else 0.0)


def _active_rows_by_interior_point(rows: UnreducedQP) -> dict[int, int] | None:
    """Return the rows that are active at PIQP's solution; None when it finds none."""
    import piqp

    H, g = rows.G.T @ rows.G, -rows.G.T @ rows.d
    unit = 1.0 / np.abs(H).max()
    solver = piqp.DenseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = 1e-11
    solver.settings.max_iter = 300
    solver.setup(H * unit, g * unit, rows.E, rows.e, rows.C, rows.low, rows.high)
    status = solver.solve()
    result = solver.result
    if status == piqp.PIQP_PRIMAL_INFEASIBLE or not np.isfinite(result.x).all():
        return None
    y = rows.C @ result.x
    active = {}
    for k in range(y.size):
        up, down = rows.high[k] - y[k], y[k] - rows.low[k]
        if result.z_u[k] > max(up, 1e-9):
            active[k] = 1
        elif result.z_l[k] > max(down, 1e-9):
            active[k] = -1
    return active


class _ActiveSet:
    """The problem with some of its rows as equalities."""

    def __init__(self, rows: UnreducedQP) -> None:
        self.rows = rows
        self.n = rows.G.shape[1]
        self.G, self.C = rows.G.astype(_LONG), rows.C.astype(_LONG)
        Q, R, order = qr(rows.E.T, pivoting=True)
        rank = int(np.count_nonzero(np.abs(np.diag(R)) > _RANK))
        self.kept = np.sort(order[:rank])
        self.null = Q[:, rank:]
        x = np.linalg.lstsq(rows.E, rows.e, rcond=_RANK)[0]
        self.consistent = bool(np.abs(rows.E @ x - rows.e).max(initial=0.0) < 1e-9)
        self.bound = np.maximum(
            1.0,
            np.maximum(
                np.where(np.isfinite(rows.low), np.abs(rows.low), 0.0),
                np.where(np.isfinite(rows.high), np.abs(rows.high), 0.0),
            ),
        )

    def exchange(self, active: dict[int, int]) -> Optimum | None:
        """Drop and add rows until the optimality conditions hold."""
        rows = self.rows
        for count in range(_EXCHANGES):
            x, multipliers, point = self.solve(active)
            y = self.C @ x
            gap = np.asarray(np.maximum(rows.low - y, y - rows.high) / self.bound, dtype=float)
            slope = self.G.T @ (self.G @ x - rows.d)
            size = self.terms(x)
            wrong = [k for k, s in multipliers.items() if s * active[k] < -_SIGN * size]
            broken = [int(k) for k in np.flatnonzero(gap > _MAX_VIOLATION)]
            if not broken and not wrong:
                return self.certified(x, active, point)
            if not broken and len(multipliers) < len(active):
                # Some active rows follow from others: these may have the wrong multipliers.
                kept = self._nonnegative_rows(slope, active)
                wrong = [k for k in active if k not in kept]
            if count > _TOGETHER:  # one row at a time, the worst
                broken = [max(broken, key=lambda k: gap[k])] if broken else []
                wrong = [] if broken else wrong[:1]
            active = {k: s for k, s in active.items() if k not in wrong}
            active |= {k: 1 if y[k] > rows.high[k] else -1 for k in broken}
        return None

    def terms(self, x: np.ndarray) -> float:
        """Return the size of the largest sum of terms of the cost's gradient."""
        G, absolute = np.abs(self.rows.G), np.abs(np.asarray(x, dtype=float))
        return float((G.T @ (G @ absolute + np.abs(self.rows.d))).max()) or 1.0

    def _nonnegative_rows(self, slope: np.ndarray, active: dict[int, int]) -> set[int]:
        """Return the active rows whose non-negative multipliers balance the gradient best."""
        order = list(active)
        sides = np.array([active[k] for k in order])
        A = (self.rows.C[order] * sides[:, None]) @ self.null
        gradient = np.asarray(self.null.T @ slope, dtype=float)
        push, _ = nnls(A.T, -gradient / np.abs(gradient).max(initial=1e-300))
        return {k for k, p in zip(order, push, strict=True) if p > 0.0}

    def dual_active_set(self) -> dict[int, int] | None:
        """Return the active rows by Goldfarb and Idnani's method; None when the rows conflict.

        With H = UᵀU along the equalities, the unknowns U p turn the cost into ½ |u|².
        """
        rows, N = self.rows, self.null
        start = np.linalg.lstsq(rows.E, rows.e, rcond=_RANK)[0]
        Q, U = np.linalg.qr(rows.G @ N)
        u = Q.T @ (rows.d - rows.G @ start)
        A = solve_triangular(U, (rows.C @ N).T, trans="T").T
        upper, lower = np.flatnonzero(np.isfinite(rows.high)), np.flatnonzero(np.isfinite(rows.low))
        A = np.vstack((A[upper], -A[lower]))
        shift = rows.C @ start
        b = np.concatenate(((rows.high - shift)[upper], -(rows.low - shift)[lower]))
        size = np.concatenate((self.bound[upper], self.bound[lower]))
        names = [(int(k), 1) for k in upper] + [(int(k), -1) for k in lower]
        chosen: list[int] = []
        push = np.zeros(0)
        for _ in range(_STEPS):
            gap = (A @ u - b) / size
            gap[chosen] = -np.inf
            k = int(np.argmax(gap))
            if gap[k] < 1e-11:
                return dict(names[i] for i in chosen)
            added = 0.0
            while True:
                basis, R = np.linalg.qr(A[chosen].T)
                inner = basis.T @ A[k]
                z = A[k] - basis @ inner
                r = solve_triangular(R, inner) if chosen else np.zeros(0)
                independent = z @ z > 1e-18 * (A[k] @ A[k]) and len(chosen) < u.size
                full = (A[k] @ u - b[k]) / (z @ z) if independent else np.inf
                limits = np.where(r > 0.0, push / np.where(r > 0.0, r, 1.0), np.inf)
                partial = limits.min(initial=np.inf)
                step = min(full, partial)
                if step == np.inf:
                    return None
                push, added = push - step * r, added + step
                u = u - step * z if independent else u
                if step == full:
                    chosen, push = [*chosen, k], np.append(push, added)
                    break
                drop = int(np.argmin(limits))
                chosen.pop(drop)
                push = np.delete(push, drop)
        return None

    def solve(self, active: dict[int, int]):
        """Return x, multipliers by row, and the factors; dependent rows have no multiplier."""
        rows = self.rows
        order = np.array(list(active), dtype=int)
        if order.size:
            A = rows.C[order] @ self.null
            _, R, pivot = qr(A.T, mode="economic", pivoting=True)
            rank = int(np.count_nonzero(np.abs(np.diag(R)) > _RANK))
            order = order[pivot[:rank]]
        sides = np.array([active[k] for k in order])
        K = np.vstack((rows.E[self.kept], rows.C[order]))
        b = np.concatenate(
            (rows.e[self.kept], np.where(sides > 0, rows.high[order], rows.low[order]))
        )
        Q, R = qr(K.T)
        k = b.size
        R, Y, Z = R[:k], Q[:, :k], Q[:, k:]
        U = np.linalg.qr(rows.G @ Z, mode="r")
        Kl = K.astype(_LONG)
        x, multipliers = np.zeros(self.n, dtype=_LONG), np.zeros(k, dtype=_LONG)
        for _ in range(10):
            left = np.asarray(b - Kl @ x, dtype=float)
            slope = np.asarray(self.G.T @ (rows.d - self.G @ x) - Kl.T @ multipliers, dtype=float)
            step = Y @ solve_triangular(R, left, trans="T")
            inner = Z.T @ (slope - rows.G.T @ (rows.G @ step))
            step = step + Z @ solve_triangular(U, solve_triangular(U, inner, trans="T"))
            slope = slope - rows.G.T @ (rows.G @ step)
            x = x + step
            multipliers = multipliers + solve_triangular(R, Y.T @ slope)
            if np.abs(step).max() < 1e-17 * np.abs(x).max():
                break
        found = dict(zip((int(i) for i in order), multipliers[self.kept.size :], strict=True))
        return x, found, (K, b, Y, R, Z, U, multipliers)

    def certified(self, x, active: dict[int, int], point) -> Optimum:
        """Return the optimum with its certificate and the attainable accuracy."""
        rows = self.rows
        K, b, Y, R, Z, U, multipliers = point
        gradient = self.G.T @ (self.G @ x - rows.d)
        left = gradient + K.T.astype(_LONG) @ multipliers
        y = self.C @ x
        gap = np.maximum(np.maximum(rows.low - y, y - rows.high) / self.bound, 0.0)
        off = np.abs(rows.E.astype(_LONG) @ x - rows.e) / np.maximum(1.0, np.abs(rows.e))
        worst = max(float(gap.max(initial=0.0)), float(off.max(initial=0.0)))
        # Rounding of K, b, GᵀG and Gᵀd, followed through the null-space solution.
        absolute = np.abs(np.asarray(x, dtype=float))
        rows_off = np.abs(K) @ absolute + np.abs(b)
        across = np.abs(Y @ solve_triangular(R, np.eye(b.size), trans="T")) @ rows_off
        size_g = np.abs(rows.G)
        slope_off = size_g.T @ (size_g @ (absolute + across) + np.abs(rows.d))
        slope_off += np.abs(K).T @ np.abs(np.asarray(multipliers, dtype=float))
        inverse = solve_triangular(U, np.eye(U.shape[0]), trans="T")
        along = np.abs(Z @ (inverse.T @ (inverse @ Z.T))) @ slope_off
        attainable = EPS * (across + along)
        proof = float(np.abs(left).max()) / self.terms(x)
        return Optimum(np.asarray(x, dtype=float), dict(active), attainable, Z, proof, worst)

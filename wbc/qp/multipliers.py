"""Lagrange multipliers of a solved problem, level by level, whatever solver it comes from."""

from __future__ import annotations

import numpy as np

from wbc.qp.problem import Problem

_ACTIVE = 1e-6  # distance of a row of unit norm from its bound that counts as none
_ZERO_NORM = 1e-9
_NEGLIGIBLE = 1e-9  # multiplier of a row of unit norm, of the size of the gradient's terms
_SETTLED = 10.0  # size of the terms of rows that are met, of their squared norm


class LevelMultipliers:
    """What holds the solution of each level in place.

    At the optimum x of level k, the gradient of its cost is balanced by the rows that hold x there,

        ∇f_k + Σ λ_i c_i + Σ_{j<k} G_jᵀ μ_j = 0,

    with λ ≥ 0 at upper and λ ≤ 0 at lower bounds, and of any sign for equalities, for the rows G_j
    of higher levels, and for inequalities that these had to violate. |λ_i| is by how much the
    cost falls per unit by which the bound of row i gives way. They follow from x by bounded least
    squares (Stark and Parker, Bounded-variable least squares, Computational Statistics 1995).

    Args:
        problem: the problem.
        x: (n,) its solution.

    Attributes:
        values: (p, bounded + m) λ of each level; zero for rows that do not hold it.
        at_upper, at_lower, at_bound: (bounded + m,) which rows are at a bound.
        count: number of levels, p.
        residual: (p,) what is left of each gradient, relative to its terms.
    """

    def __init__(self, problem: Problem, x: np.ndarray) -> None:
        self._problem, self._x = problem, x
        self._A = np.vstack((np.eye(problem.bounded, x.size), problem.C))
        norm = np.linalg.norm(self._A, axis=1)
        self._norm = np.where(norm > _ZERO_NORM, norm, 1.0)
        self._usable = norm > _ZERO_NORM
        levels = problem.levels
        self._level = np.zeros(norm.size, dtype=int) if levels is None else levels.level
        y = self._A @ x
        allowed = _ACTIVE * (1.0 + np.abs(y) / self._norm)
        self._above = (y - problem.ub) / self._norm
        self._below = (problem.lb - y) / self._norm
        self.at_upper = self._usable & (self._above > -allowed)
        self.at_lower = self._usable & (self._below > -allowed)
        self.at_bound = self.at_upper | self.at_lower
        self._conceded = np.maximum(self._above, self._below) > allowed
        self.count = 1 if levels is None else levels.starts.size
        found = [self._of_level(k) for k in range(1, self.count + 1)]
        self.values = np.array([value for value, _ in found])
        self.residual = np.array([residual for _, residual in found])

    def upper_rows(self, k: int) -> np.ndarray:
        """Return the rows of all levels before level k, 1 for the first, (q, n)."""
        levels = self._problem.levels
        if levels is None:
            return np.zeros((0, self._x.size))
        return np.asarray(levels.G[: levels.starts[k - 1], : self._x.size])

    def hessian(self, k: int) -> np.ndarray:
        """Return the Hessian of the cost of level k, (n, n)."""
        problem, levels = self._problem, self._problem.levels
        H = problem.H
        if levels is not None and k < self.count:
            G = levels.G[levels.starts[k - 1] : levels.starts[k], :-1]
            H = G.T @ G
        paying = self._paying(k)
        H = H + self._A[paying].T @ (self._weight(paying)[:, None] * self._A[paying])
        return np.asarray(H)

    def holding_rows(self, k: int) -> np.ndarray:
        """Return which rows hold level k: equalities and those with a multiplier."""
        problem = self._problem
        equal = problem.equality & (self._level == 0) & self._usable
        conceded = self._conceded & (self._level > 0) & (self._level < k)
        return np.asarray(equal | conceded | (self.values[k - 1] != 0.0))

    def _paying(self, k: int) -> np.ndarray:
        return np.asarray(self._conceded & (self._level == k))

    def _weight(self, rows: np.ndarray) -> np.ndarray:
        levels = self._problem.levels
        return np.zeros(0) if levels is None else np.asarray(levels.weight[rows])

    def _gradient(self, k: int) -> tuple[np.ndarray, float]:
        """Return the gradient of level k, and the size of its terms."""
        problem, x, levels = self._problem, self._x, self._problem.levels
        if levels is not None and k < self.count:
            rows = levels.G[levels.starts[k - 1] : levels.starts[k]]
            G, r = rows[:, :-1], rows @ np.append(x, 1.0)
            gradient, size = G.T @ r, float((np.abs(G.T) @ np.abs(r)).sum())
            size += _SETTLED * float((G**2).sum(axis=1).max(initial=0.0))
        else:
            gradient = problem.H @ x + problem.g
            size = float((np.abs(problem.H) @ np.abs(x) + np.abs(problem.g)).sum())
        paying = self._paying(k)
        violated = np.where(self._above > self._below, self._above, -self._below) * self._norm
        pushed = self._weight(paying) * violated[paying]
        return gradient + self._A[paying].T @ pushed, size + float(np.abs(pushed).sum())

    def _of_level(self, k: int) -> tuple[np.ndarray, float]:
        from scipy.optimize import lsq_linear  # not before it is needed: `import wbc` stays light

        problem = self._problem
        equal = problem.equality & (self._level == 0) & self._usable
        conceded = self._conceded & (self._level > 0) & (self._level < k)
        free = np.flatnonzero(equal | conceded)
        held = (self._level < k) & ~(equal | conceded)
        up = np.flatnonzero(held & self.at_upper)
        down = np.flatnonzero(held & self.at_lower & ~self.at_upper)
        upper = self.upper_rows(k)
        upper = upper / np.maximum(np.linalg.norm(upper, axis=1, keepdims=True), _ZERO_NORM)
        signed = np.concatenate((up, down)).astype(int)
        rows = np.vstack((self._A[free] / self._norm[free, None], upper))
        normals = self._A[signed] / self._norm[signed, None]
        gradient, size = self._gradient(k)
        values = np.zeros(self._norm.size)
        # First the rows of one sign, in what those of any sign leave; then these.
        N = np.eye(gradient.size)
        if rows.size:
            _, singular, directions = np.linalg.svd(rows)
            N = directions[int((singular > _ZERO_NORM).sum()) :].T
        if signed.size and N.size:
            sign = np.concatenate((np.ones(up.size), -np.ones(down.size)))
            left = (normals * sign[:, None]) @ N
            found = lsq_linear(left.T, -gradient @ N, (0.0, np.inf), "bvls")
            strength = np.where(found.x > _NEGLIGIBLE * (1.0 + size), found.x, 0.0)
            values[signed] = sign * strength / self._norm[signed]
        rest = gradient + self._A.T @ values
        if rows.size:
            balance = np.linalg.lstsq(rows.T, -rest, rcond=_ZERO_NORM)[0]
            values[free] = balance[: free.size] / self._norm[free]
            rest = rest + rows.T @ balance
        return values, float(np.linalg.norm(rest)) / (1.0 + size)

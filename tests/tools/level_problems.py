"""Random hierarchies of quadratic programs, and the proof that a point is their solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from wbc.qp import Problem
from wbc.qp.levels import Levels

_RANK = 1e-7
_HELD = 1e-7  # by how much a row of unit norm may miss its bound and count as held


@dataclass
class Shape:
    """Sizes of a random problem: unknowns, rows of C, rows of each level but the last."""

    unknowns: int = 12
    rows: int = 16
    levels: tuple[int, ...] = (4, 5)
    bounded: int = 4
    soft: int = 4


def random_problem(seed: int, shape: Shape, *, degenerate: bool = False) -> Problem:
    """A problem whose exact rows can hold together and whose levels are in conflict.

    Args:
        seed: of the random numbers.
        shape: sizes.
        degenerate: with rows that repeat and contradict others, within a level and across
            levels, rows of zeros, and inequalities that meet in one point.
    """
    rng = np.random.default_rng(seed)
    n, b = shape.unknowns, shape.bounded
    starts = np.concatenate(([0], np.cumsum(shape.levels))).astype(np.int64)
    G = rng.standard_normal((int(starts[-1]), n + 1))
    G[:, -1] *= 3.0
    C = rng.standard_normal((shape.rows, n))
    feasible = rng.standard_normal(n)
    if degenerate:
        G[1] = 2.0 * G[0]
        G[1, -1] += 1.0
        G[2] = 0.0
        G[starts[-2], :-1] = G[0, :-1] - G[3 % G.shape[0], :-1]
        C[2] = C[1]
        C[4] = C[3] + C[5]
    y = np.concatenate((feasible[:b], C @ feasible))
    lb, ub = y - 0.5 * rng.random(y.size), y + 0.5 * rng.random(y.size)
    if degenerate:
        ub[b + 3 : b + 6] = y[b + 3 : b + 6]
    equality = np.zeros(y.size, dtype=bool)
    equality[b : b + 2] = True
    lb[equality] = ub[equality] = y[equality]
    level, weight = np.zeros(y.size, dtype=np.int64), np.ones(y.size)
    for row in range(y.size - shape.soft, y.size):
        level[row] = rng.integers(1, starts.size + 1)
        weight[row] = rng.uniform(0.1, 3.0)
        lb[row] += 3.0 * rng.standard_normal()
        ub[row] = lb[row] + rng.random()
    R = rng.standard_normal((n, n))
    H, g = R.T @ R + 1e-3 * np.eye(n), 3.0 * rng.standard_normal(n)
    priorities = tuple(range(1, starts.size + 1))
    levels = Levels(G, starts, level, weight, priorities)
    return Problem(H, g, C, lb, ub, b, equality, (), True, levels)


def cost_of(problem: Problem, k: int, x: np.ndarray) -> float:
    """Return the cost of level k, 1 for the highest."""
    levels = problem.levels
    of_level = levels.level == k
    cost = 0.5 * float(levels.weight[of_level] @ problem.violation(x)[of_level] ** 2)
    if k < levels.starts.size:
        r = rows_of_level(problem, k) @ np.append(x, 1.0)
        return cost + 0.5 * float(r @ r)
    return cost + 0.5 * float(x @ problem.H @ x) + float(problem.g @ x)


def rows_of_level(problem: Problem, k: int) -> np.ndarray:
    """Return the residual rows of a level but the last."""
    levels = problem.levels
    return levels.G[levels.starts[k - 1] : levels.starts[k]]


def stationarity(problem: Problem, x: np.ndarray) -> list[float]:
    """Return what is left of each level's gradient, relative to its size: zero at the optimum.

    Level by level, the gradient of its cost at x must be a combination of the rows that hold it
    there: with any sign the equalities, the rows of higher levels and the inequalities that
    these violate; with a sign the inequalities that are at their bound. As every level is convex
    these conditions (Karush, Kuhn and Tucker) prove the optimum, wherever x comes from.
    """
    levels, n = problem.levels, x.size
    A = np.vstack((np.eye(problem.bounded, n), problem.C))
    norm = np.maximum(np.linalg.norm(A, axis=1), 1e-12)
    y = A @ x
    above, below = (y - problem.ub) / norm, (problem.lb - y) / norm
    off = np.maximum(above, below)
    left = []
    for k in range(1, levels.starts.size + 1):
        soft = (levels.level == k) & (off > 0.0)
        sign = np.where(above > below, 1.0, -1.0)
        largest = 0.0  # eigenvalue of the Hessian, at most
        gradients = [(levels.weight * problem.violation(x) * sign)[soft, None] * A[soft]]
        if k < levels.starts.size:
            G = rows_of_level(problem, k)
            gradients.append((G @ np.append(x, 1.0))[:, None] * G[:, :n])
            largest = float((G[:, :n] ** 2).sum())
        else:
            gradients += [(problem.H @ x)[None], problem.g[None]]
        terms = np.vstack(gradients)
        upper = [rows_of_level(problem, j)[:, :n] for j in range(1, k)]
        conceded = (levels.level > 0) & (levels.level < k) & (off > _HELD)
        free = np.vstack([A[problem.equality], A[conceded], *upper])
        held = (levels.level < k) & ~problem.equality & ~conceded
        cone = np.vstack((A[held & (above > -_HELD)], -A[held & (below > -_HELD)]))
        # Whatever the rows of any sign can balance is of no account.
        _, singular, directions = np.linalg.svd(free / _norms(free))
        rank = int((singular > _RANK).sum())
        N = directions[rank:].T
        cone = (cone / _norms(cone)) @ N
        cone = cone[np.linalg.norm(cone, axis=1) > _RANK]
        gradient = terms.sum(axis=0) @ N
        rest = lsq_linear(cone.T, -gradient, (0.0, np.inf), "bvls").fun if cone.size else gradient
        rest = float(np.linalg.norm(rest))
        scale = 1.0 + float(np.abs(terms).sum()) + largest
        left.append(rest / scale)
    return left


def _norms(rows: np.ndarray) -> np.ndarray:
    return np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-9)

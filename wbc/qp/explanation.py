"""Explains why a QP has no solution by naming the rows in conflict."""

from __future__ import annotations

import numpy as np

from wbc.qp.problem import Problem
from wbc.qp.rows import RowBlock

_NO_BOUND = 1e30
_SOFT = 8  # DAQP's flag: may be violated at a price
_SOFTNESS = 1e-9  # of the rows against the proximal term
_MAX_PROXIMAL = 10
_MIN_VIOLATION = 1e-6  # violation of a row of unit norm
_ROWS_PER_BLOCK = 2


class ElasticRows:
    """The rows of a problem, each of which may be violated at a cost.

    Finds the point that violates them least: it minimises the sum of the squared violations
    over rows scaled to unit norm, by the proximal point method
    `x⁺ = argmin ½ |x⁺ − x|² + ½ Σ sᵢ² / softness`, whose few steps DAQP solves with soft
    constraints, each warm from the last (Rockafellar, Monotone operators and the proximal
    point algorithm, SIAM J. Control and Optimization 1976).

    At the least violation the signed violations s satisfy `Aᵀ s = 0`. When they are not zero
    that is a Farkas certificate: the rows with s ≠ 0 cannot hold together.
    """

    def __init__(self, problem: Problem) -> None:
        import daqp  # not before it is needed: `import wbc` stays light

        n, bounded = problem.g.size, problem.bounded
        A = np.vstack((np.eye(bounded, n), problem.C))
        norm = np.linalg.norm(A, axis=1)
        self.norm = np.where(norm > 1e-9, norm, 1.0)  # rows of rounding errors stay small
        self.A = A / self.norm[:, None]
        lb, ub = problem.exact_bounds()
        self._lb = np.maximum(lb / self.norm, -_NO_BOUND)
        self._ub = np.minimum(ub / self.norm, _NO_BOUND)
        self._model = daqp.Model()
        self._model.settings = {"rho_soft": _SOFTNESS, "primal_tol": 1e-9, "iter_limit": 2000}
        sense = np.full(self._lb.size, _SOFT, dtype=np.int32)
        self._model.setup(np.eye(n), np.zeros(n), self.A, self._ub, self._lb, sense)

    def least_violation(self, without: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return the point that violates the rows least, and its violations.

        Args:
            without: (bounded + m,) True for rows to be left out.

        Returns:
            x (n,), and s (bounded + m,): by how much each scaled row is above its upper bound
            (positive) or below its lower one (negative).
        """
        lb, ub = self._lb, self._ub
        if without is not None:
            lb, ub = np.where(without, -_NO_BOUND, lb), np.where(without, _NO_BOUND, ub)
        x = np.zeros(self.A.shape[1])
        for _ in range(_MAX_PROXIMAL):
            start = x
            self._model.update(f=-start, bupper=ub, blower=lb)
            x, _, _, _ = self._model.solve()
            if np.linalg.norm(x - start) < 1e-9 * (1.0 + np.linalg.norm(x)):
                break
        y = self.A @ x
        return x, np.maximum(y - ub, 0.0) - np.maximum(lb - y, 0.0)


def explain(problem: Problem) -> str:
    """Return one line that names a minimal set of conflicting blocks and their worst rows.

    E.g. "cannot hold together: torque limit [leg_left_4_joint] above its maximum by 12 N·m;
    jump [z] off by 3 m/s²". A block is left out when the others are in conflict without it.
    The line is empty when all rows can hold together.
    """
    lb, ub = problem.exact_bounds()
    crossed = np.flatnonzero(lb > ub)
    if crossed.size:
        row = int(crossed[0])
        block = next(b for b in problem.blocks if row < b.stop)
        return (
            f"cannot hold: {block.label(row)} must be at least {problem.lb[row]:.4g} and at "
            f"most {problem.ub[row]:.4g} {block.unit_of(row)}"
        )
    elastic = ElasticRows(problem)
    _, violation = elastic.least_violation()
    if np.abs(violation).max(initial=0.0) < _MIN_VIOLATION:
        return ""
    conflicting, violation = _least_blocks(problem, elastic, violation)
    violation = violation * elastic.norm
    return "cannot hold together: " + "; ".join(
        _describe(problem, block, violation) for block in conflicting
    )


def _least_blocks(
    problem: Problem, elastic: ElasticRows, violation: np.ndarray
) -> tuple[list[RowBlock], np.ndarray]:
    """Return blocks none of which can be left out, and the violations of their rows alone."""
    size = np.abs(violation)

    def share(block: RowBlock) -> float:
        return float(size[block.start : block.stop].max())

    candidates = sorted((b for b in problem.blocks if share(b) > 0.0), key=share)
    without = np.ones(size.size, dtype=bool)
    for block in candidates:
        without[block.start : block.stop] = False
    conflicting = []
    for block in candidates:
        rows = slice(block.start, block.stop)
        without[rows] = True
        _, remaining = elastic.least_violation(without)
        if np.abs(remaining).max() < _MIN_VIOLATION:
            without[rows] = False
            conflicting.append(block)
    return conflicting[::-1], elastic.least_violation(without)[1]


def _describe(problem: Problem, block: RowBlock, violation: np.ndarray) -> str:
    size = np.abs(violation[block.start : block.stop])
    order = [int(k) for k in np.argsort(-size) if size[k] > 1e-3 * size.max()]
    texts = []
    for row in (block.start + k for k in order[:_ROWS_PER_BLOCK]):
        side = "above its maximum" if violation[row] > 0.0 else "below its minimum"
        side = "off" if problem.equality[row] else side
        amount = f"{abs(violation[row]):.3g} {block.unit_of(row)}"
        texts.append(f"{block.label(row)} {side} by {amount}")
    more = len(order) - len(texts)
    return ", ".join(texts) + (f" and {more} more of them" if more > 0 else "")

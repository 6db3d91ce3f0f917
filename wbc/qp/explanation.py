"""Explains why a QP has no solution by naming the rows in conflict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wbc.qp.problem import Problem

_NO_BOUND = 1e30
_SOFT = 8  # DAQP's flag: may be violated at a price
_SOFTNESS = 1e-9  # of the rows against the proximal term
_MAX_PROXIMAL = 10
_LARGEST = 1e4  # of an unknown: rad/s², or multiples of the weight; rows that need more conflict
_MIN_VIOLATION = 1e-6  # violation of a row of unit norm
_ROWS_PER_OWNER = 2  # in the text


@dataclass(frozen=True, slots=True)
class ConflictingRow:
    """A row that cannot hold together with others.

    Attributes:
        owner: task, contact or limit that the row belongs to, e.g. "torque limit".
        name: label of the row, e.g. "torque limit [leg_left_4_joint]".
        unit: of the row's values.
        equality: whether the row is an equality.
        violation: how far the row has to give way when all of them share in it, in its unit:
            positive above its upper bound, negative below its lower one.
    """

    owner: str
    name: str
    unit: str
    equality: bool
    violation: float

    def __str__(self) -> str:
        side = "above its maximum" if self.violation > 0.0 else "below its minimum"
        side = "off" if self.equality else side
        return f"{self.name} {side} by {abs(self.violation):.3g} {self.unit}"


class ElasticRows:
    """The rows of a problem, each of which may be violated at a cost.

    Finds the point that violates them least: it minimises the sum of the squared violations
    over rows scaled to unit norm, by the proximal point method
    `x⁺ = argmin ½ |x⁺ − x|² + ½ Σ sᵢ² / softness`, whose few steps DAQP solves with soft
    constraints, each warm from the last (Rockafellar, Monotone operators and the proximal
    point algorithm, SIAM J. Control and Optimization 1976).

    At the least violation the signed violations s satisfy `Aᵀ s = 0`. When they are not zero
    that is a Farkas certificate: the rows with s ≠ 0 cannot hold together. Unknowns are bounded by
    1e4: rows that only larger ones could hold are in conflict, too.
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
        sense = np.concatenate((np.full(self._lb.size, _SOFT), np.zeros(n))).astype(np.int32)
        self._largest = np.full(n, _LARGEST)
        A, lb, ub = np.vstack((self.A, np.eye(n))), *self._bounds(self._lb, self._ub)
        self._model.setup(np.eye(n), np.zeros(n), A, ub, lb, sense)

    def _bounds(self, lb: np.ndarray, ub: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.concatenate((lb, -self._largest)), np.concatenate((ub, self._largest))

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
        lower, upper = self._bounds(lb, ub)
        for _ in range(_MAX_PROXIMAL):
            start = x
            self._model.update(f=-start, bupper=upper, blower=lower)
            x, _, _, _ = self._model.solve()
            if np.linalg.norm(x - start) < 1e-9 * (1.0 + np.linalg.norm(x)):
                break
        y = self.A @ x
        return x, np.maximum(y - ub, 0.0) - np.maximum(lb - y, 0.0)


def find_conflict(problem: Problem) -> tuple[ConflictingRow, ...]:
    """Return a small set of rows that cannot hold together; empty when all rows can.

    First tasks, contacts and limits are left out as long as the others remain in conflict
    (Chinneck and Dravnieks, Locating minimal infeasible constraint sets in linear programs, ORSA
    Journal on Computing 1991), then single rows as long as the others give way by at least half as
    much: a set that is merely the smallest often conflicts by next to nothing. Of each row it tells
    how far it gives way at the point that violates the set least, see `ElasticRows`; the row that
    gives way furthest for its norm comes first. A row whose own bounds exclude each other is a
    conflict by itself.
    """
    lb, ub = problem.exact_bounds()
    crossed = np.flatnonzero(lb > ub)
    if crossed.size:
        row = int(crossed[0])
        return (_named(problem, row, float(lb[row] - ub[row])),)
    elastic = ElasticRows(problem)
    _, violation = elastic.least_violation()
    if np.abs(violation).max(initial=0.0) < _MIN_VIOLATION:
        return ()
    blocks = [np.arange(block.start, block.stop) for block in problem.blocks]
    violation = _leave_out(elastic, violation, blocks, _MIN_VIOLATION)
    rows = [np.array([row]) for row in range(violation.size)]
    violation = _leave_out(elastic, violation, rows, 0.5 * float(np.linalg.norm(violation)))
    size = np.abs(violation)
    order = [int(row) for row in np.argsort(-size, kind="stable") if size[row] > 0.0]
    return tuple(_named(problem, row, float(violation[row] * elastic.norm[row])) for row in order)


def _leave_out(
    elastic: ElasticRows, violation: np.ndarray, groups: Sequence[np.ndarray], least: float
) -> np.ndarray:
    """Leave out groups of rows while the others conflict; return the violations that remain.

    Args:
        elastic: all rows.
        violation: (bounded + m,) least violations; the rows that have none are left out.
        groups: indices of the rows of each group.
        least: norm of the violations that has to remain.
    """
    without = violation == 0.0
    size = np.abs(violation)
    candidates = [group for group in groups if not without[group].all()]
    for group in sorted(candidates, key=lambda rows: float(size[rows].max())):
        before = without.copy()
        without[group] = True
        _, remaining = elastic.least_violation(without)
        if np.linalg.norm(remaining) < least:
            without = before
        else:
            violation = remaining
    return violation


def explain(problem: Problem) -> str:
    """Return one line that names the rows in conflict, see `find_conflict`.

    E.g. "Infeasible: these constraints conflict — torque limit [leg] above its maximum by 12 N·m;
    jump [z] off by 3 m/s²". The line is empty when all rows can hold together.
    """
    rows = find_conflict(problem)
    if not rows:
        return ""
    lb, ub = problem.exact_bounds()
    crossed = np.flatnonzero(lb > ub)
    if crossed.size:
        row = int(crossed[0])
        limits = f"at least {lb[row]:.4g} and at most {ub[row]:.4g} {rows[0].unit}"
        return f"Infeasible: {rows[0].name} must be {limits}"
    owners = dict.fromkeys(row.owner for row in rows)
    texts = [_of_owner([row for row in rows if row.owner == owner]) for owner in owners]
    return "Infeasible: these constraints conflict — " + "; ".join(texts)


def _of_owner(rows: Sequence[ConflictingRow]) -> str:
    text = ", ".join(str(row) for row in rows[:_ROWS_PER_OWNER])
    more = len(rows) - _ROWS_PER_OWNER
    return f"{text} and {more} more of them" if more > 0 else text


def _named(problem: Problem, row: int, violation: float) -> ConflictingRow:
    block = next(b for b in problem.blocks if row < b.stop)
    equality = bool(problem.equality[row])
    return ConflictingRow(block.name, block.label(row), block.unit_of(row), equality, violation)

"""DAQP, called directly, warm.

Arnström, Bemporad and Axehill, A dual active-set solver for embedded quadratic
programming using recursive LDLᵀ updates, IEEE TAC 2022.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.qp.problem import Outcome, Problem, Solution

_NO_BOUND = 1e30
_EQUALITY = 5  # DAQP's flags: active and immutable
_SOLVED = (1, 4)  # optimal; optimal up to rounding errors
_INFEASIBLE = -1
_CYCLING = -2
_TOLERANCE_FACTORS = (1.0, 10.0, 100.0)  # of primal_tol, for cold solves

_ZERO_NORM = 1e-9  # norm of a zero row; share of a row that the others do not span
_CONTRADICTION = 1e-8  # of a row that follows from the others

_Key = tuple[int, int, bytes]


class DaqpSolver:
    """A dual active-set solver that starts from the active set of the last tick.

    Args:
        settings: DAQP's own, by their names. `primal_tol` is in the units of the rows.

    A warm start from an outdated active set can fail: a cold solve follows. Where bounds nearly
    coincide, as when a foot is unloaded completely, the method may cycle within `primal_tol` or
    report a conflict; it is then tried again with 10 and 100 times that tolerance. Equalities that
    follow from others are left out and checked afterwards.
    """

    name = "daqp"

    def __init__(self, **settings: float) -> None:
        # A negative eps_prox: nothing is added to H unless it is singular, which zero_tol puts
        # at a condition number of 1e12. Lower, and rounding makes redundant rows contradict.
        defaults = {"primal_tol": 1e-9, "zero_tol": 1e-12, "eps_prox": -1e-9, "iter_limit": 1000}
        self._settings = {**defaults, **settings}
        self._models: dict[_Key, _WarmModel] = {}

    def __getstate__(self) -> dict[str, Any]:
        """Return the settings: DAQP's models cannot be copied, so that a copy starts cold."""
        return {**self.__dict__, "_models": {}}

    def solve(self, problem: Problem) -> Solution:
        """See `wbc.qp.Solver`."""
        key = (problem.g.size, problem.ub.size, problem.equality.tobytes())
        warm = self._models.get(key)
        if warm is not None:
            scaled = _Scaled(problem, warm.redundant)
            warm.ub[:], warm.lb[:] = scaled.ub, scaled.lb
            # Without `sense`, the update keeps the active set. It cannot take an A without rows.
            A = scaled.C if scaled.C.shape[0] else None
            if warm.model.update(H=scaled.H, f=scaled.g, A=A, bupper=warm.ub, blower=warm.lb) >= 0:
                x, _, flag, info = warm.model.solve()
                if flag in _SOLVED and scaled.holds(x):
                    return Solution(scaled.unit * x, Outcome.SOLVED, info["iterations"])
        self._models.pop(key, None)
        return self._solve_cold(key, _Scaled(problem, _redundant(problem)))

    def _solve_cold(self, key: _Key, scaled: _Scaled) -> Solution:
        import daqp  # not before it is needed: `import wbc` stays light

        iterations = 0
        for factor in _TOLERANCE_FACTORS:
            model = daqp.Model()
            tolerance = factor * self._settings["primal_tol"]
            model.settings = {**self._settings, "primal_tol": tolerance}
            ub, lb = scaled.ub, scaled.lb
            flag, _ = model.setup(scaled.H, scaled.g, scaled.C, ub, lb, scaled.sense)
            if flag >= 0:
                x, _, flag, info = model.solve()
                iterations += info["iterations"]
                if flag in _SOLVED and scaled.holds(x):
                    if factor == 1.0:  # a model of larger tolerance is not reused
                        self._models[key] = _WarmModel(model, ub, lb, scaled.redundant)
                    return Solution(scaled.unit * x, Outcome.SOLVED, iterations)
                if flag in _SOLVED:
                    flag = _INFEASIBLE
            if flag not in (_CYCLING, _INFEASIBLE):
                break
        outcome = Outcome.INFEASIBLE if flag == _INFEASIBLE else Outcome.FAILED
        return Solution(np.zeros(key[0]), outcome, iterations, f"daqp exit flag {flag}")


class _Scaled:
    """A problem in the form for DAQP: unknowns of equal curvature, no redundant rows.

    DAQP's tolerances are absolute in the scale of the cost, and a Hessian that it considers
    singular gets proximal steps, which end before the optimum.

    Attributes:
        unit: (n,) the problem's unknowns are `unit * x`.
        redundant: rows of C that are left out.
    """

    def __init__(self, problem: Problem, redundant: np.ndarray) -> None:
        bounded = problem.bounded
        diagonal = problem.H.diagonal()
        largest = max(float(diagonal.max()), 1e-300)
        unit = np.sqrt(largest / np.where(diagonal > 1e-14 * largest, diagonal, largest))
        self.unit, self.redundant = unit, redundant
        self.H = problem.H * unit * (unit / largest)[:, None]
        self.g = problem.g * unit / largest
        self.C = problem.C * unit
        self.ub = np.minimum(problem.ub, _NO_BOUND)
        self.lb = np.maximum(problem.lb, -_NO_BOUND)
        self.ub[:bounded] /= unit[:bounded]
        self.lb[:bounded] /= unit[:bounded]
        self.sense = np.where(problem.equality, _EQUALITY, 0).astype(np.int32)
        if redundant.size:
            rows = bounded + redundant
            self._left_out, self._b = self.C[redundant], self.ub[rows].copy()
            self.C[redundant] = 0.0
            self.lb[rows], self.ub[rows], self.sense[rows] = -_NO_BOUND, _NO_BOUND, 0

    def holds(self, x: np.ndarray) -> bool:
        """Return whether x is finite and satisfies the rows that were left out."""
        if not math.isfinite(x.dot(x)):
            return False
        if not self.redundant.size:
            return True
        off = np.abs(self._left_out @ x - self._b)
        return bool((off <= _CONTRADICTION * (1.0 + np.abs(self._b))).all())


@dataclass(slots=True)
class _WarmModel:
    """A model, the arrays that it refers to, and the rows of C that were left out."""

    model: Any
    ub: np.ndarray
    lb: np.ndarray
    redundant: np.ndarray


def _redundant(problem: Problem) -> np.ndarray:
    """Return the equalities of C that are zero or follow from those before them."""
    basis = np.zeros((0, problem.g.size))
    found = []
    for row in np.flatnonzero(problem.equality[problem.bounded :]):
        left = problem.C[row]
        norm = math.sqrt(left.dot(left))
        for _ in range(2):  # twice is enough
            left = left - basis.T @ (basis @ left)
        rest = math.sqrt(left.dot(left))
        if norm < _ZERO_NORM or rest < _ZERO_NORM * norm:
            found.append(row)
        else:
            basis = np.vstack((basis, left / rest))
    return np.array(found, dtype=int)

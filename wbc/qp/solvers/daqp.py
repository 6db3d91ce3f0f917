"""DAQP, called directly, warm.

Arnström, Bemporad and Axehill, A dual active-set solver for embedded quadratic
programming using recursive LDLᵀ updates, IEEE TAC 2022.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from wbc.qp.problem import Outcome, Problem, Solution
from wbc.qp.solvers.solver import Solver

_NO_BOUND = 1e30
_EQUALITY = 5  # DAQP's flags: active and immutable
_SOLVED = (1, 4)  # optimal; optimal up to rounding errors
_INFEASIBLE = -1
_CYCLING = -2
_LOOSER = (1.0, 10.0, 100.0)  # factors on primal_tol that are tried when a cold solve cycles

_Key = tuple[int, int, bytes]


class DaqpSolver(Solver):
    """A dual active-set method that starts from the active set of the last tick.

    Args:
        settings: DAQP's own, by their names. `primal_tol` is in the units of the rows.

    A cold solve has the last word on failure: a stale active set can mislead the warm start.
    Where bounds all but coincide, as when a foot is unloaded to nothing, the method may go round
    in circles over the last digit of `primal_tol`; then it is tried again with 10 and 100 times
    that.
    """

    name = "daqp"

    def __init__(self, **settings: float) -> None:
        # A negative eps_prox: nothing is added to H unless it is singular, which zero_tol puts
        # at a condition number of 1e12. Lower, and rounding makes redundant rows contradict.
        defaults = {"primal_tol": 1e-9, "zero_tol": 1e-12, "eps_prox": -1e-9, "iter_limit": 1000}
        import daqp  # not before it is needed: `import wbc` stays light

        self._new_model = daqp.Model
        self._settings = {**defaults, **settings}
        self._models: dict[_Key, tuple[Any, np.ndarray, np.ndarray]] = {}

    def solve(self, problem: Problem) -> Solution:
        """See `Solver`."""
        # DAQP's other tolerances are absolute in the scale of the cost.
        scale = 1.0 / max(float(problem.H.diagonal().max()), 1e-300)
        H, g = problem.H * scale, problem.g * scale
        key = (g.size, problem.ub.size, problem.equality.tobytes())
        known = self._models.get(key)
        if known is None:
            return self._solve_cold(key, problem, H, g)
        model, ub, lb = known
        np.minimum(problem.ub, _NO_BOUND, out=ub)
        np.maximum(problem.lb, -_NO_BOUND, out=lb)
        # Without `sense`, the update keeps the active set. It cannot take an A without rows.
        A = problem.C if problem.C.shape[0] else None
        if model.update(H=H, f=g, A=A, bupper=ub, blower=lb) >= 0:
            x, _, flag, info = model.solve()
            if flag in _SOLVED and math.isfinite(x.dot(x)):
                return Solution(x, Outcome.SOLVED, info["iterations"])
        return self._solve_cold(key, problem, H, g)

    def _solve_cold(self, key: _Key, problem: Problem, H: np.ndarray, g: np.ndarray) -> Solution:
        self._models.pop(key, None)
        ub = np.minimum(problem.ub, _NO_BOUND)
        lb = np.maximum(problem.lb, -_NO_BOUND)
        sense = np.where(problem.equality, _EQUALITY, 0).astype(np.int32)
        iterations = 0
        for factor in _LOOSER:
            model = self._new_model()
            model.settings = {
                **self._settings,
                "primal_tol": factor * self._settings["primal_tol"],
            }
            flag, _ = model.setup(H, g, problem.C, ub, lb, sense)
            if flag >= 0:
                x, _, flag, info = model.solve()
                iterations += info["iterations"]
                if flag in _SOLVED and math.isfinite(x.dot(x)):
                    if factor == 1.0:  # a looser model is not kept for the ticks to come
                        self._models[key] = (model, ub, lb)
                    return Solution(x, Outcome.SOLVED, iterations)
            if flag != _CYCLING:
                break
        outcome = Outcome.INFEASIBLE if flag == _INFEASIBLE else Outcome.FAILED
        return Solution(np.zeros(g.size), outcome, iterations, f"daqp exit flag {flag}")

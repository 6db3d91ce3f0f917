"""DAQP, called directly, warm: the default.

Arnström, Bemporad and Axehill, A dual active-set solver for embedded quadratic
programming using recursive LDLᵀ updates, IEEE TAC 2022.
"""

from __future__ import annotations

import daqp
import numpy as np

from wbc.qp.problem import Outcome, Problem, Solution
from wbc.qp.solvers.solver import Solver

_NO_BOUND = 1e30
_EQUALITY = 5  # DAQP's flags: active and immutable
_MAX_ITERATIONS = 1000


class DaqpSolver(Solver):
    """A dual active-set method that starts from the active set of the last tick."""

    name = "daqp"

    def __init__(self) -> None:
        self._models: dict[tuple[int, int, bytes], daqp.Model] = {}

    def solve(self, problem: Problem) -> Solution:
        sense = np.where(problem.equality, _EQUALITY, 0).astype(np.int32)
        ub = np.minimum(problem.ub, _NO_BOUND)
        lb = np.maximum(problem.lb, -_NO_BOUND)
        key = (problem.H.shape[0], ub.size, sense.tobytes())
        model = self._models.get(key)
        if model is None:
            return self._solve_cold(key, problem, ub, lb, sense)
        flag = model.update(H=problem.H, f=problem.g, A=problem.C, bupper=ub, blower=lb)
        if flag >= 0:
            x, _, flag, info = model.solve()
            if flag > 0:
                return Solution(x, Outcome.SOLVED, info["iterations"])
        # A stale active set can mislead the warm start: only the cold solve's word counts.
        return self._solve_cold(key, problem, ub, lb, sense)

    def _solve_cold(
        self,
        key: tuple[int, int, bytes],
        problem: Problem,
        ub: np.ndarray,
        lb: np.ndarray,
        sense: np.ndarray,
    ) -> Solution:
        model = daqp.Model()
        model.settings = {
            "eps_prox": 0.0,
            "iter_limit": _MAX_ITERATIONS,
            "primal_tol": 1e-9,
        }
        self._models.pop(key, None)
        flag, _ = model.setup(problem.H, problem.g, problem.C, ub, lb, sense)
        iterations = 0
        if flag >= 0:
            x, _, flag, info = model.solve()
            iterations = info["iterations"]
            if flag > 0:
                self._models[key] = model
                return Solution(x, Outcome.SOLVED, iterations)
        outcome = Outcome.INFEASIBLE if flag == -1 else Outcome.FAILED
        return Solution(np.zeros(problem.g.size), outcome, iterations, f"daqp exit flag {flag}")

"""Every solver that `qpsolvers` finds, for research and comparison."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.errors import SolverNotFound, did_you_mean
from wbc.qp.problem import Outcome, Problem, Solution


class QpsolversSolver:
    """A solver by its `qpsolvers` name, set up anew for each problem.

    Args:
        name: one of `qpsolvers.available_solvers`; one that takes sparse problems only gets them
            sparse.
        options: passed to the solver untouched.

    Attributes:
        solve_time: time of the solver itself in the last call, s.

    Raises:
        SolverNotFound: no such solver, or it is not installed.
    """

    def __init__(self, name: str, **options: object) -> None:
        import qpsolvers  # imports every installed solver: seconds

        if name not in qpsolvers.available_solvers:
            names = sorted({"wbc", "daqp", "osqp", *qpsolvers.available_solvers})
            raise SolverNotFound(
                f"QP solver '{name}' is unknown or not installed{did_you_mean(name, names)} "
                f"(most solvers come with  pip install {name}  or  pip install 'wbc[solvers]' )"
            )
        self.name = name
        self.solve_time = 0.0
        self._options = options
        self._sparse = name not in qpsolvers.dense_solvers

    def solve(self, problem: Problem) -> Solution:
        """See `wbc.qp.Solver`."""
        import qpsolvers

        n = problem.g.size
        try:
            qp = qpsolvers.Problem(*self._arguments(problem))
            found = qpsolvers.solve_problem(qp, solver=self.name, **self._options)
        except Exception as error:
            return Solution(np.zeros(n), Outcome.FAILED, detail=f"{self.name}: {error}")
        self.solve_time = found.solve_time or 0.0
        if found.found and found.x is not None and np.isfinite(found.x).all():
            return Solution(found.x, Outcome.SOLVED)
        # qpsolvers reports "not found" alike for infeasible problems and failures.
        return Solution(np.zeros(n), Outcome.FAILED, detail=f"{self.name} found no solution")

    def _arguments(self, problem: Problem) -> tuple[Any, ...]:
        """Return P, q, G, h, A, b, lb and ub of `qpsolvers.Problem`."""
        bounded, n = problem.bounded, problem.g.size
        lb, ub = np.full(n, -np.inf), np.full(n, np.inf)
        lb[:bounded], ub[:bounded] = problem.lb[:bounded], problem.ub[:bounded]
        equal = problem.equality[bounded:]
        low, high, C = problem.lb[bounded:], problem.ub[bounded:], problem.C
        below, above = ~equal & np.isfinite(low), ~equal & np.isfinite(high)
        P, G = problem.H, np.vstack((C[above], -C[below]))
        A = C[equal] if equal.any() else None
        if self._sparse:
            from scipy.sparse import csc_matrix

            P, G, A = csc_matrix(P), csc_matrix(G), None if A is None else csc_matrix(A)
        h = np.concatenate((high[above], -low[below]))
        return P, problem.g, G, h, A, None if A is None else high[equal], lb, ub

"""Every dense solver that `qpsolvers` finds, for research and comparison."""

from __future__ import annotations

import numpy as np

from wbc.errors import SolverNotFound, did_you_mean
from wbc.qp.problem import Outcome, Problem, Solution


class QpsolversSolver:
    """A solver by its `qpsolvers` name, set up afresh for each problem.

    Args:
        name: one of `qpsolvers.dense_solvers`.
        options: passed to the solver untouched.

    Raises:
        SolverNotFound: no such solver, or it is not installed.
    """

    def __init__(self, name: str, **options: object) -> None:
        import qpsolvers  # imports every installed solver: seconds

        if name not in qpsolvers.available_solvers:
            known = sorted({"wbc", "daqp", "osqp", *qpsolvers.dense_solvers})
            raise SolverNotFound(
                f"QP solver '{name}' is unknown or not installed{did_you_mean(name, known)} "
                f"(most solvers come with  pip install {name}  or  pip install 'wbc[solvers]' )"
            )
        if name not in qpsolvers.dense_solvers:
            raise SolverNotFound(
                f"QP solver '{name}' takes sparse problems only; "
                f"dense ones are: {', '.join(sorted({'wbc', 'daqp', *qpsolvers.dense_solvers}))}"
            )
        self.name = name
        self._options = options

    def solve(self, problem: Problem) -> Solution:
        """See `wbc.qp.Solver`."""
        import qpsolvers

        b = problem.bounded
        n = problem.g.size
        lb, ub = np.full(n, -np.inf), np.full(n, np.inf)
        lb[:b], ub[:b] = problem.lb[:b], problem.ub[:b]
        equal = problem.equality[b:]
        low, high, C = problem.lb[b:], problem.ub[b:], problem.C
        below, above = ~equal & np.isfinite(low), ~equal & np.isfinite(high)
        qp = qpsolvers.Problem(
            problem.H,
            problem.g,
            np.vstack((C[above], -C[below])),
            np.concatenate((high[above], -low[below])),
            C[equal] if equal.any() else None,
            high[equal] if equal.any() else None,
            lb,
            ub,
        )
        try:
            found = qpsolvers.solve_problem(qp, solver=self.name, **self._options)
        except Exception as error:
            return Solution(np.zeros(n), Outcome.FAILED, detail=f"{self.name}: {error}")
        if found.found and found.x is not None and np.isfinite(found.x).all():
            return Solution(np.array(found.x, dtype=float), Outcome.SOLVED)
        # qpsolvers reports "not found" alike for infeasible problems and failures.
        return Solution(np.zeros(n), Outcome.FAILED, detail=f"{self.name} found no solution")

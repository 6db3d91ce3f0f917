"""OSQP with a workspace that is updated in place.

Stellato, Banjac, Goulart, Bemporad and Boyd, OSQP: an operator splitting solver for
quadratic programs, Mathematical Programming Computation 2020.
"""

from __future__ import annotations

import numpy as np

from wbc.errors import MissingExtra
from wbc.qp.problem import Outcome, Problem, Solution
from wbc.qp.solvers.solver import Solver

_NO_BOUND = 1e30


class OsqpSolver(Solver):
    """An operator-splitting method; a few digits, meant for large sparse problems.

    Args:
        tolerance: absolute and relative.
        max_iterations: before it gives up.
    """

    name = "osqp"

    def __init__(self, tolerance: float = 1e-7, max_iterations: int = 20000) -> None:
        try:
            import osqp
            from scipy import sparse
        except ImportError as error:
            raise MissingExtra(error.name or "osqp", "solvers") from error
        self._osqp = osqp
        self._sparse = sparse
        self._tolerance = tolerance
        self._max_iterations = max_iterations
        self._workspaces: dict[tuple[int, int, int], object] = {}

    def solve(self, problem: Problem) -> Solution:
        n, b, m = problem.g.size, problem.bounded, problem.C.shape[0]
        lb = np.maximum(problem.lb, -_NO_BOUND)
        ub = np.minimum(problem.ub, _NO_BOUND)
        upper = np.triu_indices(n)
        # Column-major order of the upper triangle, as OSQP stores it.
        order = np.lexsort((upper[0], upper[1]))
        H_values = problem.H[upper[0][order], upper[1][order]]
        workspace = self._workspaces.get((n, b, m))
        if workspace is None:
            workspace = self._setup(problem, H_values, lb, ub, upper, order)
            self._workspaces[(n, b, m)] = workspace
        else:
            workspace.update(q=problem.g, l=lb, u=ub, Px=H_values, Ax=_columns(problem.C, b))  # type: ignore[attr-defined]
        result = workspace.solve(raise_error=False)  # type: ignore[attr-defined]
        status = result.info.status_val
        codes = self._osqp.SolverStatus
        if status == codes.OSQP_SOLVED:
            return Solution(np.asarray(result.x), Outcome.SOLVED, result.info.iter)
        infeasible = (codes.OSQP_PRIMAL_INFEASIBLE, codes.OSQP_PRIMAL_INFEASIBLE_INACCURATE)
        outcome = Outcome.INFEASIBLE if status in infeasible else Outcome.FAILED
        del self._workspaces[(n, b, m)]  # its iterates may be poisoned
        return Solution(np.zeros(n), outcome, result.info.iter, f"osqp: {result.info.status}")

    def _setup(
        self,
        problem: Problem,
        H_values: np.ndarray,
        lb: np.ndarray,
        ub: np.ndarray,
        upper: tuple[np.ndarray, ...],
        order: np.ndarray,
    ) -> object:
        n, b, m = problem.g.size, problem.bounded, problem.C.shape[0]
        sparse = self._sparse
        columns = np.concatenate(([0], np.cumsum(np.arange(1, n + 1))))
        P = sparse.csc_matrix((H_values, upper[0][order], columns), shape=(n, n))
        # Every entry of C is kept as structure, also those that are zero today.
        rows = [
            np.concatenate(([j], b + np.arange(m))) if j < b else b + np.arange(m)
            for j in range(n)
        ]
        starts = np.concatenate(([0], np.cumsum([r.size for r in rows])))
        A = sparse.csc_matrix(
            (_columns(problem.C, b), np.concatenate(rows), starts), shape=(b + m, n)
        )
        workspace = self._osqp.OSQP()
        workspace.setup(
            P,
            problem.g,
            A,
            lb,
            ub,
            verbose=False,
            eps_abs=self._tolerance,
            eps_rel=self._tolerance,
            max_iter=self._max_iterations,
            polishing=False,
        )
        return workspace


def _columns(C: np.ndarray, bounded: int) -> np.ndarray:
    """Values of [I; C] column by column, the identity on the bounded variables."""
    m, n = C.shape
    values = np.empty(bounded * (m + 1) + (n - bounded) * m)
    head = values[: bounded * (m + 1)].reshape(bounded, m + 1)
    head[:, 0] = 1.0
    head[:, 1:] = C[:, :bounded].T
    values[bounded * (m + 1) :] = C[:, bounded:].T.ravel()
    return values

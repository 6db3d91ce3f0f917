"""OSQP with a workspace that is updated in place.

Stellato, Banjac, Goulart, Bemporad and Boyd, OSQP: an operator splitting solver for
quadratic programs, Mathematical Programming Computation 2020.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.errors import SolverNotFound
from wbc.qp.problem import Outcome, Problem, Solution

_NO_BOUND = 1e30


class OsqpSolver:
    """An operator-splitting solver of moderate accuracy, meant for large sparse problems.

    Args:
        settings: OSQP's own, by their names; `eps_abs` and `eps_rel` are 1e-9 when left out,
            `max_iter` is 20000.

    Raises:
        SolverNotFound: OSQP is not installed.
    """

    name = "osqp"

    def __init__(self, **settings: Any) -> None:
        try:
            import osqp  # noqa: F401 - not before it is needed: `import wbc` stays light
            import scipy.sparse  # noqa: F401
        except ImportError as error:
            raise SolverNotFound(
                f"QP solver 'osqp' needs '{error.name}', which is not installed; "
                "run  pip install osqp"
            ) from error
        defaults = {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000, "verbose": False}
        self._settings = {**defaults, **settings}
        self._workspaces: dict[tuple[int, int, int], _OsqpWorkspace] = {}

    def __getstate__(self) -> dict[str, Any]:
        """Return the settings: OSQP's workspaces cannot be copied, so that a copy starts cold."""
        return {**self.__dict__, "_workspaces": {}}

    def solve(self, problem: Problem) -> Solution:
        """See `wbc.qp.Solver`."""
        from osqp import SolverStatus

        key = (problem.g.size, problem.bounded, problem.C.shape[0])
        workspace = self._workspaces.get(key)
        if workspace is None:
            workspace = _OsqpWorkspace(problem, self._settings)
            self._workspaces[key] = workspace
        else:
            workspace.update(problem)
        result = workspace.solver.solve(raise_error=False)
        status, codes = result.info.status_val, SolverStatus
        x = np.asarray(result.x, dtype=float)
        if status == codes.OSQP_SOLVED and np.isfinite(x).all():
            return Solution(x, Outcome.SOLVED, result.info.iter)
        infeasible = (codes.OSQP_PRIMAL_INFEASIBLE, codes.OSQP_PRIMAL_INFEASIBLE_INACCURATE)
        outcome = Outcome.INFEASIBLE if status in infeasible else Outcome.FAILED
        del self._workspaces[key]  # its iterates may not be finite
        detail = f"osqp: {result.info.status}"
        return Solution(np.zeros(problem.g.size), outcome, result.info.iter, detail)


class _OsqpWorkspace:
    """OSQP, set up once for problems of one size with dense H and C."""

    def __init__(self, problem: Problem, settings: dict[str, Any]) -> None:
        import osqp
        from scipy import sparse

        n, b, m = problem.g.size, problem.bounded, problem.C.shape[0]
        # OSQP stores the upper triangle of H column by column.
        columns, rows = np.tril_indices(n)
        self._upper = (rows, columns)
        starts = np.concatenate(([0], np.cumsum(np.arange(1, n + 1))))
        P = sparse.csc_matrix((problem.H[self._upper], rows, starts), shape=(n, n))
        # [I; C]: the identity belongs to the bounded variables.
        dense = np.arange(b, b + m)
        row_lists = [np.concatenate(([j], dense)) if j < b else dense for j in range(n)]
        starts = np.concatenate(([0], np.cumsum([r.size for r in row_lists])))
        A = sparse.csc_matrix(
            (_columns(problem), np.concatenate(row_lists), starts), shape=(b + m, n)
        )
        self.solver = osqp.OSQP()
        self.solver.setup(P, problem.g, A, *_clipped(problem), **settings)

    def update(self, problem: Problem) -> None:
        """Replace the numbers of the problem; its structure stays."""
        lb, ub = _clipped(problem)
        H = problem.H[self._upper]
        self.solver.update(q=problem.g, l=lb, u=ub, Px=H, Ax=_columns(problem))


def _clipped(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    return np.maximum(problem.lb, -_NO_BOUND), np.minimum(problem.ub, _NO_BOUND)


def _columns(problem: Problem) -> np.ndarray:
    """Return the values of [I; C], column by column."""
    C, bounded = problem.C, problem.bounded
    m, n = C.shape
    values = np.empty(bounded * (m + 1) + (n - bounded) * m)
    head = values[: bounded * (m + 1)].reshape(bounded, m + 1)
    head[:, 0] = 1.0
    head[:, 1:] = C[:, :bounded].T
    values[bounded * (m + 1) :] = C[:, bounded:].T.ravel()
    return values

"""Any solver that `qpsolvers` finds, sparse ones included, with the time that is the solver's."""

from __future__ import annotations

from typing import Any

from wbc.errors import SolverNotFound
from wbc.qp.solvers.qpsolvers import QpsolversSolver


class ThroughQpsolvers(QpsolversSolver):
    """The library's adapter; a solver that takes sparse problems only gets them sparse.

    Args:
        name: one of `qpsolvers.available_solvers`.
        options: passed to the solver untouched.

    Raises:
        SolverNotFound: no such solver, or it is not installed.
    """

    def __init__(self, name: str, **options: object) -> None:
        import qpsolvers  # imports every installed solver: seconds

        if name not in qpsolvers.available_solvers:
            raise SolverNotFound(f"QP solver '{name}' is unknown or not installed")
        self.name = name
        self._options = options
        self._noting = self._qpsolvers = _Noting(qpsolvers, name not in qpsolvers.dense_solvers)

    @property
    def inside(self) -> float:
        """What the solver itself took of the last call, s."""
        return self._noting.inside


class _Noting:
    """What the adapter needs of `qpsolvers`, noting the solver's own time."""

    def __init__(self, qpsolvers: Any, sparse: bool) -> None:
        self._qpsolvers, self._sparse = qpsolvers, sparse
        self.inside = 0.0

    def Problem(self, P: Any, q: Any, G: Any, h: Any, A: Any, *rest: Any) -> Any:
        if self._sparse:
            from scipy.sparse import csc_matrix

            P, G, A = (None if X is None else csc_matrix(X) for X in (P, G, A))
        return self._qpsolvers.Problem(P, q, G, h, A, *rest)

    def solve_problem(self, *args: Any, **options: Any) -> Any:
        found = self._qpsolvers.solve_problem(*args, **options)
        self.inside = found.solve_time or 0.0
        return found

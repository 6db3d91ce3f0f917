"""QP solvers by name, one adapter per file."""

from wbc.qp.solvers.daqp import DaqpSolver
from wbc.qp.solvers.solver import Solver

__all__ = ["DaqpSolver", "Solver", "make_solver"]


def make_solver(name: str = "daqp", **options: object) -> Solver:
    """A solver by its name.

    Args:
        name: "daqp" (the default), "osqp" (persistent workspace), or the name of any
            dense solver that `qpsolvers` finds installed ("quadprog", "proxqp", …).
        options: passed on to the solver, by its own names.

    Raises:
        SolverNotFound: unknown or not installed; the text says what is there.
    """
    if name == "daqp":
        return DaqpSolver(**options)  # type: ignore[arg-type]
    if name == "osqp":
        from wbc.qp.solvers.osqp import OsqpSolver

        return OsqpSolver(**options)  # type: ignore[arg-type]
    from wbc.qp.solvers.qpsolvers import QpsolversSolver

    return QpsolversSolver(name, **options)

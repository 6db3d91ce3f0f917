"""QP solvers by name, one adapter per file."""

from wbc.errors import SolverNotFound, WbcError, short_repr
from wbc.qp.kernel_loading import load_qp_kernels
from wbc.qp.solvers.daqp import DaqpSolver
from wbc.qp.solvers.solver import NamedSolver, Solver

__all__ = ["DaqpSolver", "NamedSolver", "Solver", "make_solver", "resolve_solver"]


def make_solver(name: str | None = None, **options: object) -> NamedSolver:
    """Return a solver by its name.

    Args:
        name: "wbc" (the library's own, compiled), "daqp", "osqp" (persistent workspace), or
            the name of any solver that `qpsolvers` finds installed ("quadprog", "proxqp",
            …). When left out: "wbc", or "daqp" where kernels cannot be compiled.
        options: passed on to the solver, by its own names.

    Raises:
        SolverNotFound: it is unknown or not installed; the text lists what is.
    """
    if name is None:
        name = "wbc" if load_qp_kernels() else "daqp"
    if name == "wbc":
        if not load_qp_kernels():
            raise SolverNotFound(
                "QP solver 'wbc' needs Numba; run  pip install numba  or take 'daqp'"
            )
        from wbc.qp.solvers.compiled import CompiledSolver

        return CompiledSolver(**options)  # type: ignore[arg-type]
    if name == "daqp":
        return DaqpSolver(**options)  # type: ignore[arg-type]
    if name == "osqp":
        from wbc.qp.solvers.osqp import OsqpSolver

        return OsqpSolver(**options)  # type: ignore[arg-type]
    from wbc.qp.solvers.qpsolvers import QpsolversSolver

    return QpsolversSolver(name, **options)


def resolve_solver(solver: str | Solver | None) -> Solver:
    """Return the solver of a name (see `make_solver`) or the object itself.

    Raises:
        SolverNotFound: see `make_solver`.
        WbcError: the object has no method `solve`.
    """
    if solver is None or isinstance(solver, str):
        return make_solver(solver)
    if isinstance(solver, type) or not isinstance(solver, Solver):
        raise WbcError(
            f"solver = {short_repr(solver)} is neither a name nor an object with a method "
            "solve(problem) -> Solution; see wbc.qp.Solver"
        )
    return solver

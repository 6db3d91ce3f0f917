"""Quadratic program: elimination, assembly, solvers and explanations of infeasibility."""

from wbc.qp.assembly import Assembly, Formulation
from wbc.qp.cost import Regularisation
from wbc.qp.explanation import ConflictingRow, explain, find_conflict
from wbc.qp.kernel_loading import load_qp_kernels
from wbc.qp.problem import Outcome, Problem, Solution
from wbc.qp.row_errors import non_finite_rows
from wbc.qp.solvers import Solver, make_solver, resolve_solver
from wbc.qp.tick_explanation import (
    ActiveRow,
    TaskGain,
    TaskResult,
    TickExplanation,
    explain_solution,
)

__all__ = [
    "ActiveRow",
    "Assembly",
    "ConflictingRow",
    "Formulation",
    "Outcome",
    "Problem",
    "Regularisation",
    "Solution",
    "Solver",
    "TaskGain",
    "TaskResult",
    "TickExplanation",
    "explain",
    "explain_solution",
    "find_conflict",
    "load_qp_kernels",
    "make_solver",
    "non_finite_rows",
    "resolve_solver",
]

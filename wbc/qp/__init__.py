"""The quadratic program: elimination, assembly, solvers, explanation."""

from wbc.qp.assembly import Assembly, Formulation, Regularisation
from wbc.qp.explanation import explain, least_violation
from wbc.qp.problem import Outcome, Problem, Solution
from wbc.qp.solvers import Solver, make_solver

__all__ = [
    "Assembly",
    "Formulation",
    "Outcome",
    "Problem",
    "Regularisation",
    "Solution",
    "Solver",
    "explain",
    "least_violation",
    "make_solver",
]

"""The quadratic program: elimination, assembly, solvers, explanation."""

from wbc.qp.assembly import Assembly, Formulation
from wbc.qp.cost import Regularisation
from wbc.qp.explanation import explain
from wbc.qp.loading import KernelsMissing, kernels_load
from wbc.qp.problem import Outcome, Problem, Solution
from wbc.qp.solvers import Solver, make_solver
from wbc.qp.writing import not_finite

__all__ = [
    "Assembly",
    "Formulation",
    "KernelsMissing",
    "Outcome",
    "Problem",
    "Regularisation",
    "Solution",
    "Solver",
    "explain",
    "kernels_load",
    "make_solver",
    "not_finite",
]

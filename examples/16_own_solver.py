"""Write your own solver: a class with `solve(problem)`.

This one solves the QP as a least-distance problem by non-negative least squares (Lawson and Hanson,
Solving Least Squares Problems, 1974, chapter 23).
"""

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

import wbc
from wbc.qp import Outcome, Problem, Solution


class NonNegativeLeastSquares:
    """With H = L Lᵀ and y = Lᵀ x + L⁻¹ g, the QP minimises |y| subject to `R y ≥ d`."""

    def solve(self, problem: Problem) -> Solution:
        """Solve one QP. Its arrays belong to the controller and must not be modified."""
        n = problem.g.size
        L = np.linalg.cholesky(problem.H)
        w = solve_triangular(L, problem.g, lower=True)
        A = np.vstack((np.eye(problem.bounded, n), problem.C))
        A = np.vstack((A, -A))
        b = np.concatenate((problem.lb, -problem.ub))
        A, b = A[np.isfinite(b)], b[np.isfinite(b)]
        R = solve_triangular(L, A.T, lower=True).T
        d = b + R @ w
        E, f = np.vstack((R.T, d)), np.eye(n + 1)[n]
        u, distance = nnls(E, f, maxiter=10 * len(b))
        if distance < 1e-9:
            return Solution(np.zeros(n), Outcome.INFEASIBLE, detail="no point satisfies all rows")
        r = E @ u - f
        y = -r[:n] / r[n]
        return Solution(solve_triangular(L.T, y - w, lower=False), Outcome.SOLVED)


robot = wbc.load("simple_humanoid")
commands = []
for solver in (None, NonNegativeLeastSquares()):
    controller = wbc.WholeBodyController(robot, solver=solver)
    controller.add(wbc.ComTask())
    controller.add(wbc.PostureTask(robot))
    controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
    commands.append(controller.step(robot.standing()))
ours, own = commands
print("own solver:", own.status.value)
print(f"torques differ by {np.abs(ours.tau - own.tau).max():.1e} N·m")

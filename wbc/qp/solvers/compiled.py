"""The library's own dual active-set method, compiled: the default where Numba is."""

from __future__ import annotations

import math

import numpy as np

from wbc.qp.kernels.dual_active_set import SOLVED, solve
from wbc.qp.problem import Outcome, Problem, Solution
from wbc.qp.solvers.daqp import DaqpSolver
from wbc.qp.solvers.solver import Solver

_TOLERANCE = 1e-9
_ITERATIONS = 400


class CompiledSolver(Solver):
    """A dual active-set method that starts from the working set of the last tick.

    See `wbc.qp.kernels.dual_active_set`. What it does not solve, warm nor cold, is given to
    DAQP, which has the last word on failure.

    Args:
        tolerance: by how much a row of unit norm may be violated.
    """

    name = "wbc"

    def __init__(self, tolerance: float = _TOLERANCE) -> None:
        self._tolerance = tolerance
        self._rooms: dict[tuple[int, int], _Room] = {}
        self._second = DaqpSolver()

    def solve(self, problem: Problem) -> Solution:
        """See `Solver`."""
        n, rows = problem.C.shape[1], problem.lb.size
        room = self._rooms.get((n, rows))
        if room is None:
            room = self._rooms[(n, rows)] = _Room(n, rows)
        outcome = self._attempt(problem, room)
        if outcome is None and room.warm:
            room.forget()
            outcome = self._attempt(problem, room)
        if outcome is not None:
            room.warm = True
            return outcome
        room.forget()
        return self._second.solve(problem)

    def _attempt(self, problem: Problem, room: _Room) -> Solution | None:
        code = solve(
            problem.H,
            problem.g,
            problem.C,
            problem.lb,
            problem.ub,
            problem.bounded,
            problem.equality,
            self._tolerance,
            _ITERATIONS,
            *room.arrays,
        )
        x = room.x
        if code != SOLVED or not math.isfinite(x.dot(x)):
            return None
        return Solution(x.copy(), Outcome.SOLVED, int(room.counts[1]))


class _Room:
    """Working set and work space for problems of one size."""

    def __init__(self, n: int, rows: int) -> None:
        self.counts = np.zeros(2, dtype=np.int64)
        line = np.zeros((5, rows + 2 * n + 2))
        self.arrays = (
            self.counts,
            np.zeros(n + 1, dtype=np.int64),
            np.zeros(n + 1, dtype=np.int64),
            np.zeros(n + 1),
            np.zeros((4, n + 1, n + 1)),
            line,
        )
        self.x = line[0, :n]
        self.warm = False

    def forget(self) -> None:
        """Start the next solve from no working set."""
        self.counts[0] = 0
        self.warm = False

"""The library's own dual active-set method, compiled: the default where Numba is."""

from __future__ import annotations

import math

import numpy as np

from wbc.qp.kernels.dual_active_set import NOT_CONVEX, SOLVED, solve
from wbc.qp.problem import Outcome, Problem, Solution
from wbc.qp.solvers.daqp import DaqpSolver
from wbc.qp.solvers.solver import Solver

_TOLERANCE = 1e-9
_ITERATIONS = 200
_LOOSER = (1.0, 10.0, 100.0)  # factors on the tolerance that are tried when a cold solve fails


class CompiledSolver(Solver):
    """A dual active-set method that starts from the working set of the last tick.

    See `wbc.qp.kernels.dual_active_set`. A stale working set can mislead it: a cold solve
    follows. Where many rows all but meet in a point, as when a foot is unloaded to nothing, it
    may go round in circles over the last digit of its tolerance, or take that digit for a
    contradiction: so it is tried with 10 and 100 times that. What it still does not solve is
    given to DAQP, which has the last word.

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
        if self._attempt(problem, room, self._tolerance) == SOLVED:
            return room.solution()
        room.forget()
        if self._attempt(problem, room, self._tolerance) == SOLVED:
            return room.solution()
        second = self._second.solve(problem)
        if second.outcome is Outcome.SOLVED:
            room.forget()
            return second
        for factor in _LOOSER[1:]:
            room.forget()
            if self._attempt(problem, room, factor * self._tolerance) == SOLVED:
                return room.solution()
        room.forget()
        return second

    def _attempt(self, problem: Problem, room: _Room, tolerance: float) -> int:
        code = solve(
            problem.H,
            problem.g,
            problem.C,
            problem.lb,
            problem.ub,
            problem.bounded,
            problem.equality,
            tolerance,
            _ITERATIONS,
            *room.arrays,
        )
        if code == SOLVED and not math.isfinite(room.x.dot(room.x)):
            return NOT_CONVEX
        return int(code)


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

    def solution(self) -> Solution:
        """What the last solve found."""
        return Solution(self.x.copy(), Outcome.SOLVED, int(self.counts[1]))

    def forget(self) -> None:
        """Start the next solve from no working set."""
        self.counts[0] = 0

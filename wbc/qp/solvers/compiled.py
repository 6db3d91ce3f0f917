"""The library's own dual active-set method, compiled: the default where Numba is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from wbc.qp.kernels.dual_active_set import NOT_CONVEX, SOLVED, solve
from wbc.qp.problem import Outcome, Problem, Solution
from wbc.qp.solvers.daqp import DaqpSolver

_TOLERANCE = 1e-9
_ITERATIONS = 200
_LOOSER = (1.0, 10.0, 100.0)  # factors on the tolerance that are tried when a cold solve fails


class CompiledSolver:
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
        self._workspaces: dict[tuple[int, int], _Workspace] = {}

    def solve(self, problem: Problem) -> Solution:
        """See `wbc.qp.Solver`."""
        key = problem.C.shape[1], problem.lb.size
        workspace = self._workspaces.get(key)
        if workspace is None:
            workspace = self._workspaces[key] = _Workspace(*key)
        if self._attempt(problem, workspace, self._tolerance) == SOLVED:
            return workspace.solution()
        workspace.reset()
        if self._attempt(problem, workspace, self._tolerance) == SOLVED:
            return workspace.solution()
        second = DaqpSolver().solve(problem)
        if second.outcome is Outcome.SOLVED:
            workspace.reset()
            return second
        for factor in _LOOSER[1:]:
            workspace.reset()
            if self._attempt(problem, workspace, factor * self._tolerance) == SOLVED:
                return workspace.solution()
        workspace.reset()
        return second

    def _attempt(self, problem: Problem, workspace: _Workspace, tolerance: float) -> int:
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
            *workspace.arrays,
        )
        if code == SOLVED and not math.isfinite(workspace.x.dot(workspace.x)):
            return NOT_CONVEX
        return int(code)


class _Workspace:
    """Working set and memory for problems of one size.

    Args:
        n: number of unknowns.
        rows: number of rows, simple bounds included.
    """

    def __init__(self, n: int, rows: int) -> None:
        self._size = n, rows
        self._counts = np.zeros(2, dtype=np.int64)
        self._rows, self._sides = np.zeros((2, n + 1), dtype=np.int64)
        self._multipliers = np.zeros(n + 1)
        lines = np.zeros((5, rows + 2 * n + 2))
        matrices = np.zeros((4, n + 1, n + 1))
        self.arrays = (
            self._counts,
            self._rows,
            self._sides,
            self._multipliers,
            matrices,
            lines,
        )
        self.x = lines[0, :n]

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy the working set and its multipliers: all that one solve leaves to the next."""
        kept = self._counts, self._rows, self._sides, self._multipliers
        return _Workspace, self._size, kept

    def __setstate__(self, kept: tuple[np.ndarray, ...]) -> None:
        for array, values in zip(self.arrays, kept, strict=False):
            array[:] = values

    def solution(self) -> Solution:
        """Return what the last solve found."""
        return Solution(self.x.copy(), Outcome.SOLVED, int(self._counts[1]))

    def reset(self) -> None:
        """Start the next solve from an empty working set."""
        self._counts[0] = 0

"""The solver of strict priorities, compiled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.errors import WbcError
from wbc.qp.kernels.dual_active_set import INFEASIBLE, NOT_CONVEX, SOLVED
from wbc.qp.kernels.hierarchy import HIERARCHY_GROUPS, LevelWorkspace, solve_levels
from wbc.qp.kernels.schema import Memory
from wbc.qp.levels import Levels
from wbc.qp.problem import Outcome, Problem, Solution

_TOLERANCE = 1e-9
_ITERATIONS = 200
_TOLERANCE_FACTORS = (1.0, 10.0, 100.0)  # of cold solves
_DETAIL = {NOT_CONVEX: "the cost of the last level is not strictly convex"}

_Key = tuple[int, int, int, bytes, bytes, bytes]


class HierarchicalSolver:
    """Solves problems with `Levels`, each from the working sets and the solution of the last.

    See `wbc.qp.kernels.hierarchy`. A warm start from outdated working sets can fail: a cold solve
    follows, then ones with 10 and 100 times the tolerance.

    Args:
        tolerance: largest violation of a row of unit norm.
    """

    def __init__(self, tolerance: float = _TOLERANCE) -> None:
        self._tolerance = tolerance
        self._states: dict[_Key, _HierarchyState] = {}

    def solve(self, problem: Problem) -> Solution:
        """Return the solution of a problem that has levels.

        Raises:
            WbcError: the problem has none.
        """
        levels = problem.levels
        if levels is None:
            raise WbcError("this problem has no levels: solve it with a solver of wbc.qp.solvers")
        starts, level = levels.starts, levels.level
        equality = problem.equality.tobytes()
        sizes = problem.g.size, level.size, starts.size
        key = (*sizes, starts.tobytes(), level.tobytes(), equality)
        state = self._states.get(key)
        if state is None:
            state = self._states[key] = _HierarchyState(_sizes_of(problem, levels))
        code = self._attempt(problem, levels, state, self._tolerance)
        for factor in _TOLERANCE_FACTORS:
            if code == SOLVED:
                return state.solution()
            state.reset()
            code = self._attempt(problem, levels, state, factor * self._tolerance)
        if code == SOLVED:
            return state.solution()
        state.reset()
        outcome = Outcome.INFEASIBLE if code == INFEASIBLE else Outcome.FAILED
        detail = _DETAIL.get(code, f"levels: outcome {code} after {state.iterations} iterations")
        return Solution(np.zeros(problem.g.size), outcome, state.iterations, detail)

    def _attempt(
        self, problem: Problem, levels: Levels, state: _HierarchyState, tolerance: float
    ) -> int:
        code = solve_levels(
            levels.G,
            levels.starts,
            problem.H,
            problem.g,
            problem.C,
            problem.lb,
            problem.ub,
            problem.bounded,
            problem.equality,
            levels.level,
            levels.weight,
            tolerance,
            _ITERATIONS,
            *state.arrays,
        )
        if code == SOLVED and not math.isfinite(state.x.dot(state.x)):
            return NOT_CONVEX
        return int(code)


@dataclass(frozen=True)
class _HierarchySizes:
    """Lengths of the arrays, see `wbc.qp.kernels.hierarchy`."""

    unknowns: int
    rows: int
    levels: int
    level_rows: int
    capacity: int


def _sizes_of(problem: Problem, levels: Levels) -> _HierarchySizes:
    starts = levels.starts
    equalities = int((problem.equality & (levels.level == 0)).sum())
    largest = max(1, equalities, *np.diff(starts))
    n, soft = problem.g.size, int((levels.level > 0).sum())
    return _HierarchySizes(n, levels.level.size, starts.size, largest, n + soft + 1)


class _HierarchyState:
    """Memory for problems of one structure."""

    def __init__(self, sizes: _HierarchySizes) -> None:
        self._sizes = sizes
        memory = Memory(HIERARCHY_GROUPS, sizes)
        self.arrays = memory.arrays
        self.work = memory.group(LevelWorkspace)
        self.x = self.work.x

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy what one solve hands on to the next: the solution and the working sets."""
        return _HierarchyState, (self._sizes,), self._carried()

    def __setstate__(self, saved: tuple[np.ndarray, ...]) -> None:
        for array, values in zip(self._carried(), saved, strict=True):
            array[:] = values

    def _carried(self) -> tuple[np.ndarray, ...]:
        work = self.work
        return (work.x, work.kept_size, work.kept_row, work.kept_side, work.kept_multiplier)

    @property
    def iterations(self) -> int:
        """Iterations of the last solve, of all levels."""
        return int(self.work.iterations[0])

    def solution(self) -> Solution:
        """Return what the last solve found."""
        return Solution(self.x.copy(), Outcome.SOLVED, self.iterations)

    def reset(self) -> None:
        """Start the next solve from empty working sets and from zero."""
        self.x.fill(0.0)
        self.work.kept_size.fill(0)

"""The solver of strict priorities, compiled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.errors import WbcError
from wbc.qp.kernels.dual_active_set import INFEASIBLE, NOT_CONVEX, SOLVED
from wbc.qp.kernels.hierarchy import HIERARCHY_GROUPS, solve_levels
from wbc.qp.kernels.level_memory import LevelWorkspace
from wbc.qp.kernels.schema import Memory
from wbc.qp.levels import Levels
from wbc.qp.problem import Outcome, Problem, Solution

_TOLERANCE = 1e-9
_ITERATIONS = 200
_TOLERANCE_FACTORS = (1.0, 10.0, 100.0)  # of cold solves
_RECORDED = 2  # rows of working sets per unknown
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
        self._start = np.empty(0)

    def solve(self, problem: Problem) -> Solution:
        """Return the solution of a problem that has levels.

        Raises:
            WbcError: the problem has none.
        """
        levels = problem.levels
        if levels is None:
            raise WbcError("this problem has no levels: solve it with a solver of wbc.qp.solvers")
        key = _key_of(problem, levels)
        state = self._states.get(key)
        if state is None:
            state = self._states[key] = _HierarchyState(_sizes_of(problem, levels))
            state.start_from(self._start)
        state.remember_start()
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

    def working_set(self, problem: Problem) -> np.ndarray:
        """Return where the last solve of a problem's structure began: x and the working sets.

        From there, by `start_from`, it is solved again to the same bits.
        """
        assert problem.levels is not None
        return self._states[_key_of(problem, problem.levels)].working_set()

    def start_from(self, working_set: np.ndarray) -> None:
        """Begin the first solve of each structure that this fits from it; see `working_set`."""
        self._start = np.array(working_set, dtype=float)

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


def _key_of(problem: Problem, levels: Levels) -> _Key:
    starts, level = levels.starts, levels.level
    sizes = problem.g.size, level.size, starts.size
    return (*sizes, starts.tobytes(), level.tobytes(), problem.equality.tobytes())


def _sizes_of(problem: Problem, levels: Levels) -> _HierarchySizes:
    starts = levels.starts
    equalities = int((problem.equality & (levels.level == 0)).sum())
    largest = max(1, equalities, *np.diff(starts))
    n, soft = problem.g.size, int((levels.level > 0).sum())
    return _HierarchySizes(n, levels.level.size, starts.size, largest + soft, n + soft + 1)


class _HierarchyState:
    """Memory for problems of one structure."""

    def __init__(self, sizes: _HierarchySizes) -> None:
        self._sizes = sizes
        memory = Memory(HIERARCHY_GROUPS, sizes)
        self.arrays = memory.arrays
        self.work = memory.group(LevelWorkspace)
        self.x = self.work.x
        self._start = tuple(array.copy() for array in self._carried())

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

    def remember_start(self) -> None:
        """Keep what the next solve begins with."""
        for kept, array in zip(self._start, self._carried(), strict=True):
            np.copyto(kept, array)

    def working_set(self) -> np.ndarray:
        """See `HierarchicalSolver.working_set`.

        x, then the size of each working set, row + 1 with the sign of its side, multipliers. At
        most two rows per unknown; what is beyond is left out.
        """
        x, sizes, rows, sides, multipliers = self._start
        n = x.size
        chosen = np.zeros((2, _RECORDED * n))
        begin = 0
        for k, size in enumerate(sizes):
            part = slice(begin, min(begin + size, _RECORDED * n))
            count = part.stop - part.start
            chosen[0, part] = (rows[k, :count] + 1) * sides[k, :count]
            chosen[1, part] = multipliers[k, :count]
            begin = part.stop
        return np.concatenate((x, sizes, *chosen))

    def start_from(self, working_set: np.ndarray) -> None:
        """See `HierarchicalSolver.start_from`."""
        work, n = self.work, self.x.size
        levels = work.kept_size.size
        if working_set.size != (1 + 2 * _RECORDED) * n + levels:
            return  # of another problem
        sizes = working_set[n : n + levels].astype(np.int64)
        rows, multipliers = working_set[n + levels :].reshape(2, -1)
        wrong = (sizes < 0) | (sizes > work.kept_row.shape[1])
        if wrong.any() or sizes.sum() > rows.size or (np.abs(rows) > self._sizes.rows).any():
            return
        self.x[:], work.kept_size[:] = working_set[:n], sizes
        begin = 0
        for k, size in enumerate(sizes):
            part = slice(begin, begin + size)
            work.kept_row[k, :size] = np.abs(rows[part]) - 1
            work.kept_side[k, :size] = np.sign(rows[part])
            work.kept_multiplier[k, :size] = multipliers[part]
            begin = part.stop

    def reset(self) -> None:
        """Start the next solve from empty working sets and from zero."""
        self.x.fill(0.0)
        self.work.kept_size.fill(0)

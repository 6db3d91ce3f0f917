"""The library's own dual active-set solver, compiled: the default when Numba is installed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.qp.kernels.dual_active_set import (
    NOT_CONVEX,
    SOLVED,
    SOLVER_GROUPS,
    solve,
)
from wbc.qp.kernels.schema import Memory
from wbc.qp.kernels.working_set import WorkingSet, Workspace
from wbc.qp.problem import Outcome, Problem, Solution
from wbc.qp.solvers.daqp import DaqpSolver

_TOLERANCE = 1e-9
_ITERATIONS = 200
_TOLERANCE_FACTORS = (10.0, 100.0)  # tried when a cold solve fails


class CompiledSolver:
    """A dual active-set solver that starts from the working set of the last tick.

    See `wbc.qp.kernels.dual_active_set`. A warm start from an outdated working set can fail: a
    cold solve follows, then one by DAQP. Where many rows nearly meet in a point, as when a foot
    is unloaded completely, the method may cycle within its tolerance or report a conflict; a
    problem that DAQP cannot solve either is tried again with 10 and 100 times the tolerance.

    Args:
        tolerance: largest violation of a row of unit norm.
    """

    name = "wbc"

    def __init__(self, tolerance: float = _TOLERANCE) -> None:
        self._tolerance = tolerance
        self._states: dict[tuple[int, int], _SolverState] = {}
        self._start = np.empty(0)

    def working_set(self, problem: Problem) -> np.ndarray:
        """Return where the last solve of a problem of this size ended.

        Returns:
            (2 n + 1,) its size, then its rows and their sides, see `WorkingSet`.
        """
        state = self._states.get((problem.C.shape[1], problem.lb.size))
        if state is None:
            return np.zeros(2 * problem.g.size + 1)
        return state.working_set()

    def start_from(self, working_set: np.ndarray) -> None:
        """Start the first solve from a working set; see `working_set`."""
        self._start = np.asarray(working_set)

    def solve(self, problem: Problem) -> Solution:
        """See `wbc.qp.Solver`."""
        key = problem.C.shape[1], problem.lb.size
        state = self._states.get(key)
        if state is None:
            state = self._states[key] = _SolverState(*key)
            if self._start.size == 2 * key[0] + 1:
                state.start_from(self._start)
        if self._attempt(problem, state, self._tolerance) == SOLVED:
            return state.solution()
        state.reset()
        if self._attempt(problem, state, self._tolerance) == SOLVED:
            return state.solution()
        fallback = DaqpSolver().solve(problem)
        if fallback.outcome is Outcome.SOLVED:
            state.reset()
            return fallback
        for factor in _TOLERANCE_FACTORS:
            state.reset()
            if self._attempt(problem, state, factor * self._tolerance) == SOLVED:
                return state.solution()
        state.reset()
        return fallback

    def _attempt(self, problem: Problem, state: _SolverState, tolerance: float) -> int:
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
            *state.arrays,
        )
        if code == SOLVED and not math.isfinite(state.x.dot(state.x)):
            return NOT_CONVEX
        return int(code)


@dataclass(frozen=True)
class _Sizes:
    """Lengths of the solver's arrays, see `wbc.qp.kernels.dual_active_set`."""

    unknowns: int
    rows: int

    @property
    def capacity(self) -> int:
        """Rows that fit into the working set, and one that is to be exchanged."""
        return self.unknowns + 1


class _SolverState:
    """Working set and memory for problems of one size.

    Args:
        unknowns: number of unknowns.
        rows: number of rows, simple bounds included.
    """

    def __init__(self, unknowns: int, rows: int) -> None:
        self._sizes = (unknowns, rows)
        memory = Memory(SOLVER_GROUPS, _Sizes(unknowns, rows))
        self.arrays = memory.arrays
        self._active = memory.group(WorkingSet)
        self.x = memory.group(Workspace).x

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy the working set and its multipliers: all that one solve hands on to the next."""
        active = self._active
        return _SolverState, self._sizes, (active.size, active.row, active.side, active.multiplier)

    def __setstate__(self, saved: tuple[np.ndarray, ...]) -> None:
        active = self._active
        targets = (active.size, active.row, active.side, active.multiplier)
        for array, values in zip(targets, saved, strict=True):
            array[:] = values

    def solution(self) -> Solution:
        """Return what the last solve found."""
        return Solution(self.x.copy(), Outcome.SOLVED, int(self._active.iterations[0]))

    def working_set(self) -> np.ndarray:
        """See `CompiledSolver.working_set`."""
        active, n = self._active, self.x.size
        return np.concatenate((active.size, active.row[:n], active.side[:n]))

    def start_from(self, working_set: np.ndarray) -> None:
        """See `CompiledSolver.start_from`."""
        active, n = self._active, self.x.size
        rows = working_set[1 : n + 1].astype(np.int64)
        if (rows >= self._sizes[1]).any():
            return  # of another problem
        active.row[:n], active.side[:n] = rows, working_set[n + 1 :]
        active.size[0] = min(int(working_set[0]), n)
        active.multiplier[:] = 0.0

    def reset(self) -> None:
        """Start the next solve from an empty working set."""
        self._active.size[0] = 0

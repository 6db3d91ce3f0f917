"""Strict priorities: a sequence of least-squares problems, each among the optima of those before.

Level k minimises, over the x that hold all rows of level 0 and are optimal for the levels before,

    ½ |G_k x̂|² + ½ Σ ω_i w_i²,    lb ≤ C_k x + w ≤ ub,

and the last one the QP's cost `½ xᵀ H x + gᵀ x`, which is strictly convex (Kanoun, Lamiraux and
Wieber, Kinematic control of redundant manipulators: generalizing the task-priority framework to
inequality tasks, IEEE T-RO 2011; Escande, Mansard and Wieber, Hierarchical quadratic programming:
fast online humanoid-robot motion generation, IJRR 2014).

A level first tries the working set that it had in the last tick. If that is not the optimum's, in
coordinates p of equal cost (`wbc.qp.kernels.null_space`) it is a least-distance problem

    min ½ |p|²   subject to   lb ≤ C x(p) + w ≤ ub,

solved by the dual active-set method of `wbc.qp.kernels.dual_active_set`; a row that may be
violated has 1/ω on the diagonal of K. Directions that a level is indifferent to get a small cost
there. From that point a primal method, which does without this cost, goes on to the optimum
(`wbc.qp.kernels.level_optimum`). Rows with a positive multiplier are then held where they are:
moving off them would cost the level something.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from wbc.jit.compile import kernel, subkernel
from wbc.qp.kernels.dual_active_set import (
    INFEASIBLE,
    ITERATION_LIMIT,
    NEGLIGIBLE,
    NOT_CONVEX,
    NOT_EXACT,
    SOLVED,
    first_to_vanish,
    most_violated,
)
from wbc.qp.kernels.factors import factor_row, solve_factored
from wbc.qp.kernels.level_memory import LevelWorkspace, copy_row
from wbc.qp.kernels.level_optimum import (
    close_level,
    minimize_costs,
    move_to_optimum,
    repeat_level,
)
from wbc.qp.kernels.null_space import (
    LevelRows,
    factor_rows,
    from_coordinates,
    least_squares,
    put_row,
    reduce_cost,
    square,
    to_coordinates,
)
from wbc.qp.kernels.schema import reader
from wbc.qp.kernels.working_set import (
    Inequality,
    WorkingSet,
    exchange,
    refactor,
    remove,
    scale_of,
    value_of,
)

_SCALE = 100.0  # of directions that a level is indifferent to, its rows being of norm one: a
# larger one costs precision, and the primal method makes good what a smaller one misses
_DETERMINED = 1e-9  # share of a row that must be left to count as free
_CONSISTENT = 1e-8  # by how much equalities that follow from others may miss
_SLACK = 1e-6  # by how much a row that higher levels determine may be violated by rounding


class Coordinates(NamedTuple):
    """The coordinates of one level; see `wbc.qp.kernels.null_space.to_coordinates`.

    Attributes:
        first: first entry that is left to the level.
        stop: first entry that the level is indifferent to.
        rank: stop − first, or −1 on the last level.
        weighted: whether there is a Λ.
        indifferent: scale of the entries from `stop` on.
        sensitive: largest scale of the others.
    """

    first: int
    stop: int
    rank: int
    weighted: bool
    indifferent: float
    sensitive: float


HIERARCHY_GROUPS = (WorkingSet, LevelWorkspace, LevelRows)
_read_working_set = reader(HIERARCHY_GROUPS, WorkingSet)
_read_workspace = reader(HIERARCHY_GROUPS, LevelWorkspace)
_read_level_rows = reader(HIERARCHY_GROUPS, LevelRows)


@subkernel
def put_equalities(
    rows: Inequality, level: np.ndarray, work: LevelWorkspace, linear: LevelRows, first: int
) -> int:
    """Make the equalities of level 0 the rows to be met; returns their number."""
    size = 0
    for row in range(rows.lb.size):
        if rows.is_equality[row] and level[row] == 0:
            work.used[row] = 2
            factor = abs(scale_of(rows, row, work.scale))
            copy_row(rows, row, 1.0, work.step)
            put_row(linear, size, work.step, -rows.ub[row], factor, first)
            size += 1
    return size


@subkernel
def unit_of(G: np.ndarray) -> float:
    """Return the factor that makes the largest of residual rows one of norm one."""
    n, largest = G.shape[1] - 1, 0.0
    for r in range(G.shape[0]):
        s = 0.0
        for c in range(n):
            s += G[r, c] * G[r, c]
        largest = max(largest, s)
    return 1.0 / math.sqrt(largest) if largest > 1e-20 else 1.0


@subkernel
def append_row(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    at: Coordinates,
    row: int,
    side: int | np.int64,
    k: int,
) -> None:
    """Put a row at place k of the working set; the factor is left to `factor_row`."""
    n = work.x.size
    active.row[k], active.side[k] = row, side
    m = active.M[k]
    copy_row(rows, row, 1.0 if side > 0 else -1.0, m)
    to_coordinates(linear, m, at.first, at.rank, at.weighted, at.indifferent)
    value = value_of(rows, row, linear.center)
    active.d[k] = rows.ub[row] - value if side > 0 else value - rows.lb[row]
    for j in range(k + 1):
        s = 0.0
        for c in range(at.first, n):
            s += m[c] * active.M[j, c]
        active.K[k, j] = s
    active.K[k, k] += work.softness[row]


@subkernel
def largest_of(values: np.ndarray) -> float:
    """Return the largest absolute value, or one."""
    largest = 1.0
    for value in values:
        largest = max(largest, abs(value))
    return largest


@subkernel
def keep(active: WorkingSet, work: LevelWorkspace, k: int, size: int) -> None:
    """Keep the working set of a level for the next solve."""
    for i in range(size):
        work.kept_row[k, i], work.kept_side[k, i] = active.row[i], active.side[i]
        work.kept_multiplier[k, i] = active.multiplier[i]
    work.kept_size[k] = size


@subkernel
def put_kept(rows: Inequality, active: WorkingSet, work: LevelWorkspace, k: int) -> int:
    """Fill the working set with what the level had in the last solve; returns its size."""
    size = 0
    for i in range(work.kept_size[k]):
        row, side = work.kept_row[k, i], work.kept_side[k, i]
        bound = rows.ub[row] if side > 0 else rows.lb[row]
        if work.used[row] == 0 and abs(bound) < 1e20:
            active.row[size], active.side[size] = row, side
            work.used[row] = 1
            size += 1
    return size


@subkernel
def is_determined(active: WorkingSet, work: LevelWorkspace, at: Coordinates, k: int) -> bool:
    """Return whether nothing that is left to the level changes the row at place k."""
    row, s, t = active.row[k], 0.0, 0.0
    for c in range(at.first, at.stop):
        s += active.M[k, c] ** 2
    for c in range(at.stop, active.M.shape[1]):
        t += active.M[k, c] ** 2
    free = math.sqrt(s) / at.sensitive + math.sqrt(t) / at.indifferent
    determined: bool = free * abs(work.scale[row]) < _DETERMINED and work.softness[row] == 0.0
    return determined


@subkernel
def move_to(
    active: WorkingSet, work: LevelWorkspace, linear: LevelRows, at: Coordinates, size: int
) -> None:
    """Compute x of the multipliers: x = x̄ + what p = −Mᵀ λ means."""
    n, p = work.x.size, work.step
    for c in range(n):
        p[c] = 0.0
    for k in range(size):
        factor = active.multiplier[k]
        for c in range(at.first, n):
            p[c] -= factor * active.M[k, c]
    if size > 0:
        from_coordinates(linear, p, at.first, at.rank, at.weighted, at.indifferent)
    for i in range(n):
        work.x[i] = linear.center[i] + p[i]


@subkernel
def polish(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    at: Coordinates,
    size: int,
    tolerance: float,
) -> float:
    """Bring the rows of the working set to their bounds up to rounding errors.

    Returns:
        By how much one of them is off, for its scale.
    """
    x, residual, p, n = work.x, work.residual, work.step, work.x.size
    worst = 0.0
    for attempt in range(5):
        worst = 0.0
        for k in range(size):
            row = active.row[k]
            y = value_of(rows, row, x)
            residual[k] = y - rows.ub[row] if active.side[k] > 0 else rows.lb[row] - y
            residual[k] -= work.softness[row] * active.multiplier[k]
            worst = max(worst, abs(residual[k]) * abs(scale_of(rows, row, work.scale)))
        if not worst > 0.05 * tolerance or attempt == 4:
            break
        solve_factored(active.F, residual, size)
        for c in range(n):
            p[c] = 0.0
        for k in range(size):
            active.multiplier[k] += residual[k]
            for c in range(at.first, n):
                p[c] += residual[k] * active.M[k, c]
        from_coordinates(linear, p, at.first, at.rank, at.weighted, at.indifferent)
        for i in range(n):
            x[i] -= p[i]
    return worst


@subkernel
def start_level(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    at: Coordinates,
    k: int,
) -> int:
    """Fill the working set with what the level had in the last tick; returns its size."""
    size = 0
    for i in range(work.kept_size[k]):
        row, side = work.kept_row[k, i], work.kept_side[k, i]
        bound = rows.ub[row] if side > 0 else rows.lb[row]
        if work.used[row] != 0 or not abs(bound) < 1e20:
            continue
        scale_of(rows, row, work.scale)
        append_row(rows, active, work, linear, at, row, side, size)
        if is_determined(active, work, at, size):
            continue
        if factor_row(active.K, active.F, size):
            work.used[row] = 1
            active.multiplier[size] = max(work.kept_multiplier[k, i], 0.0)
            size += 1
    return size


@subkernel
def release(active: WorkingSet, work: LevelWorkspace, size: int) -> None:
    """Empty the working set."""
    for k in range(size):
        work.used[active.row[k]] = 0


@subkernel
def least_distance(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    at: Coordinates,
    size: int,
    tolerance: float,
    limit: int,
) -> tuple[int, int]:
    """Solve `min ½ |p|²` from a working set; returns the outcome and the working set's size."""
    target = work.target
    for _ in range(limit):
        work.iterations[0] += 1
        for k in range(size):
            target[k] = -active.d[k]
        solve_factored(active.F, target, size)
        gone, share = first_to_vanish(active, target, size, rows.is_equality, NEGLIGIBLE)
        if gone >= 0:
            for k in range(size):
                active.multiplier[k] += share * (target[k] - active.multiplier[k])
            work.used[active.row[gone]] = 0
            remove(active, gone, size)
            size = refactor(active, work, gone, size - 1, 0)
            continue
        for k in range(size):
            active.multiplier[k] = target[k]
        move_to(active, work, linear, at, size)
        off = polish(rows, active, work, linear, at, size, tolerance)
        row, side = most_violated(rows, work, tolerance)
        if row < 0:
            return (SOLVED if off <= tolerance else NOT_EXACT), size
        if work.scale[row] < 0.0:
            return INFEASIBLE, size
        append_row(rows, active, work, linear, at, row, side, size)
        if is_determined(active, work, at, size):
            y = value_of(rows, row, work.x)
            off = max(y - rows.ub[row], rows.lb[row] - y) * work.scale[row]
            if off > _SLACK:
                return INFEASIBLE, size
            work.used[row] = 2
            continue
        active.multiplier[size] = 0.0
        size = exchange(rows, active, work, size)
        if size < 0:
            return INFEASIBLE, 0
        work.used[row] = 1
        size += 1
    return ITERATION_LIMIT, size


@subkernel
def solve_level(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    G: np.ndarray,
    first: int,
    unit: float,
    k: int,
    tolerance: float,
    limit: int,
) -> tuple[int, int, int]:
    """Solve one level but the last, from any working set.

    Returns:
        The outcome, the size of the working set, the first coordinate that neither the working
        set nor the level determines.
    """
    n = work.x.size
    for i in range(n):
        linear.center[i] = work.start[i]
    count, rank = minimize_costs(rows, active, work, linear, G, 0, first, unit)
    sensitive = 1.0
    for c in range(rank):
        sensitive = max(sensitive, 1.0 / abs(linear.A[c, first + c]))
    at = Coordinates(first, first + rank, rank, count > rank, _SCALE, sensitive)
    size = start_level(rows, active, work, linear, at, k - 1)
    outcome, size = least_distance(rows, active, work, linear, at, size, tolerance, limit)
    if outcome != SOLVED:
        if k == 1:
            return outcome, size, first
        release(active, work, size)
        size = 0
        for i in range(n):  # the solution of the level before holds all rows, too
            work.x[i] = work.start[i]
    found, size, stop = move_to_optimum(
        rows, active, work, linear, G, first, size, unit, tolerance, limit
    )
    return (SOLVED if found else ITERATION_LIMIT), size, stop


@kernel(
    "int64(float64[:,::1], int64[::1], float64[:,::1], float64[::1], float64[:,::1], "
    "float64[::1], float64[::1], int64, boolean[::1], int64[::1], float64[::1], float64, int64, "
    "float64[::1], int64[::1], int64[:,::1])"
)
def solve_levels(
    G: np.ndarray,
    starts: np.ndarray,
    H: np.ndarray,
    g: np.ndarray,
    C: np.ndarray,
    lb: np.ndarray,
    ub: np.ndarray,
    bounded: int,
    is_equality: np.ndarray,
    level: np.ndarray,
    weight: np.ndarray,
    tolerance: float,
    limit: int,
    real_arrays: np.ndarray,
    integer_arrays: np.ndarray,
    table: np.ndarray,
) -> int:
    """Solve level by level; the solution is left in `LevelWorkspace.x`.

    Args:
        G: (q, n + 1) residual rows of all levels but the last.
        starts: (p,) where each of the levels begins in G, and the end: p − 1 levels and the last.
        H, g, C, lb, ub: cost of the last level, and constraints of all.
        bounded: number of simple bounds, on the first unknowns.
        is_equality: (r,) see `wbc.qp.problem`.
        level: (r,) 0 for rows that hold exactly, otherwise the level that pays for a violation.
        weight: (r,) ω.
        tolerance: by how much a row of unit norm may be violated.
        limit: largest number of iterations of one level.
        real_arrays, integer_arrays, table: the arrays of a `Memory` of `HIERARCHY_GROUPS`.

    Returns:
        As `wbc.qp.kernels.dual_active_set.solve`.
    """
    active = _read_working_set(real_arrays, integer_arrays, table)
    work = _read_workspace(real_arrays, integer_arrays, table)
    linear = _read_level_rows(real_arrays, integer_arrays, table)
    rows = Inequality(C, work.lower, work.upper, bounded, is_equality)
    n, last = work.x.size, starts.size
    for row in range(lb.size):
        work.lower[row], work.upper[row] = lb[row], ub[row]
        work.scale[row] = 0.0
        work.softness[row] = 0.0
        work.used[row] = 1 if level[row] > 0 else 0
    for i in range(n):
        linear.center[i] = work.x[i]
    work.iterations[0] = 0
    count = put_equalities(rows, level, work, linear, 0)
    first = factor_rows(linear, count, 0)
    left = least_squares(linear, count, first, 0)
    if left > _CONSISTENT * largest_of(linear.center):
        return INFEASIBLE
    for k in range(1, last):
        Gk = G[starts[k - 1] : starts[k]]
        unit = unit_of(Gk)
        for row in range(lb.size):
            if level[row] == k:
                work.used[row] = 0
                work.softness[row] = 1.0 / (weight[row] * unit * unit)
        for i in range(n):
            work.start[i] = linear.center[i]
        size = put_kept(rows, active, work, k - 1)
        found, stop = repeat_level(rows, active, work, linear, Gk, first, size, unit, tolerance)
        if not found:
            release(active, work, size)
            outcome, size, stop = solve_level(
                rows, active, work, linear, Gk, first, unit, k, tolerance, limit
            )
            if outcome != SOLVED:
                work.kept_size[k - 1] = 0
                return outcome
        keep(active, work, k - 1, size)
        first = close_level(rows, active, work, linear, Gk, first, size, stop, unit)
        for row in range(lb.size):
            work.softness[row] = 0.0
        for i in range(n):
            linear.center[i] = work.x[i]
    if not reduce_cost(linear, H, g, first):
        return NOT_CONVEX
    sensitive, left_over = 0.0, n - first
    for c in range(left_over):
        sensitive = max(sensitive, square(linear.L, left_over)[c, c])
    for row in range(lb.size):
        if level[row] == last:
            work.used[row] = 0
            work.softness[row] = 1.0 / weight[row]
    at = Coordinates(first, n, -1, True, 1.0, sensitive)
    size = start_level(rows, active, work, linear, at, last - 1)
    outcome, size = least_distance(rows, active, work, linear, at, size, tolerance, limit)
    keep(active, work, last - 1, size if outcome == SOLVED else 0)
    return outcome

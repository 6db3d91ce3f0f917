"""Strict priorities: a sequence of least-squares problems, each among the optima of those before.

Level k minimises, over the x that hold all rows of level 0 and are optimal for the levels before,

    ½ |G_k x̂|² + ½ Σ ω_i w_i²,    lb ≤ C_k x + w ≤ ub,

and the last one the QP's cost `½ xᵀ H x + gᵀ x`, which is strictly convex (Kanoun, Lamiraux and
Wieber, Kinematic control of redundant manipulators: generalizing the task-priority framework to
inequality tasks, IEEE T-RO 2011; Escande, Mansard and Wieber, Hierarchical quadratic programming:
fast online humanoid-robot motion generation, IJRR 2014).

In coordinates p of equal cost (`wbc.qp.kernels.null_space`) a level is a least-distance problem

    min ½ |p|²   subject to   lb ≤ C x(p) + w ≤ ub,

solved by the dual active-set method of `wbc.qp.kernels.dual_active_set` from the working set that
the level had in the last tick; a row that may be violated has 1/ω on the diagonal of K. Directions
that a level is indifferent to get a small proximal cost around the last solution, and the centre
moves until the multipliers that come from this cost alone have vanished. Rows with a positive
multiplier are then held where they are: moving off them would cost the level something.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

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
from wbc.qp.kernels.null_space import (
    LevelRows,
    add_reflection,
    factor_rows,
    from_coordinates,
    least_squares,
    put_row,
    reduce_cost,
    reflect,
    reflect_back,
    square,
    to_coordinates,
)
from wbc.qp.kernels.schema import integers, reader, reals
from wbc.qp.kernels.working_set import (
    Inequality,
    WorkingSet,
    exchange,
    refactor,
    remove,
    scale_of,
    value_of,
)

_SCALE = 1e4  # of directions that a level is indifferent to, its rows being of norm one: least
_LARGEST_SCALE = 1e6
_ABOVE_SENSITIVE = 100.0  # scale of these directions for the largest of the others
_PROXIMAL_STEPS = 30
_CONVERGED = 1e-9  # error of the multipliers that no longer matters, for the largest of them
_ROUNDED = 1e-5  # share of itself by which rounding changes a multiplier
_NEGLIGIBLE = 1e-10  # as `NEGLIGIBLE`, where a proximal cost determines small multipliers
_SENSITIVITY = 1e5  # multipliers per gradient of the proximal cost, before a step has shown it
_DETERMINED = 1e-9  # share of a row that must be left to count as free
_FORCED = 1e-7  # multiplier of a row that a level holds on to, for the largest of them
_LEAST_LARGEST = 1e-2  # what counts as the largest multiplier when all are small
_CONSISTENT = 1e-8  # by how much equalities that follow from others may miss
_SLACK = 1e-6  # by how much a row that higher levels determine may be violated by rounding


class LevelWorkspace(NamedTuple):
    """Memory of one solve; `x` and the kept working sets carry over to the next.

    Attributes:
        x: the solution.
        scale: one over the norm of each row.
        used: 1 for rows that are not to be added: active, determined, or of a lower level.
        target: multipliers at which the working set meets its bounds.
        residual: by how much it misses them.
        step: p, or a correction of x.
        lower, upper: bounds, moved by what higher levels had to concede.
        softness: 1/ω of the rows of the present level; 0 for those that hold exactly.
        kept_size: number of rows of each level's working set.
        kept_row, kept_side, kept_multiplier: working set of each level.
        unit: scale of each level's rows, the root of that of its cost and multipliers.
        iterations: of all levels.
    """

    x: Annotated[np.ndarray, reals("unknowns")]
    scale: Annotated[np.ndarray, reals("rows")]
    used: Annotated[np.ndarray, integers("rows")]
    target: Annotated[np.ndarray, reals("capacity")]
    residual: Annotated[np.ndarray, reals("capacity")]
    step: Annotated[np.ndarray, reals("unknowns")]
    lower: Annotated[np.ndarray, reals("rows")]
    upper: Annotated[np.ndarray, reals("rows")]
    softness: Annotated[np.ndarray, reals("rows")]
    kept_size: Annotated[np.ndarray, integers("levels")]
    kept_row: Annotated[np.ndarray, integers("levels", "capacity")]
    kept_side: Annotated[np.ndarray, integers("levels", "capacity")]
    kept_multiplier: Annotated[np.ndarray, reals("levels", "capacity")]
    unit: Annotated[np.ndarray, reals("levels")]
    iterations: Annotated[np.ndarray, integers(1)]


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
def put_level(linear: LevelRows, G: np.ndarray, begin: int, end: int, first: int) -> float:
    """Make rows of G those to be met, the largest of norm one; returns the factor."""
    n, largest = linear.center.size, 0.0
    for r in range(begin, end):
        s = 0.0
        for c in range(n):
            s += G[r, c] * G[r, c]
        largest = max(largest, s)
    unit = 1.0 / math.sqrt(largest) if largest > 1e-20 else 1.0
    for r in range(begin, end):
        put_row(linear, r - begin, G[r], G[r, n], unit, first)
    return unit


@subkernel
def copy_row(rows: Inequality, row: int, sign: float, out: np.ndarray) -> None:
    """out ← the coefficients of x in a row of the constraints."""
    for i in range(out.size):
        out[i] = 0.0
    if row < rows.bounded:
        out[row] = sign
    else:
        c = rows.C[row - rows.bounded]
        for i in range(out.size):
            out[i] = sign * c[i]


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
def largest_multiplier(active: WorkingSet, work: LevelWorkspace, size: int) -> float:
    """Return the largest multiplier of rows of norm one, or `_LEAST_LARGEST`."""
    largest = _LEAST_LARGEST
    for k in range(size):
        largest = max(largest, abs(active.multiplier[k] / work.scale[active.row[k]]))
    return largest


@subkernel
def keep(active: WorkingSet, work: LevelWorkspace, k: int, size: int) -> float:
    """Keep the working set of a level.

    Returns:
        By how much a multiplier differs from the one kept before; infinity for another set.
    """
    change = 0.0 if work.kept_size[k] == size else np.inf
    for i in range(size):
        row, multiplier = active.row[i], active.multiplier[i]
        if work.kept_row[k, i] != row or work.kept_side[k, i] != active.side[i]:
            change = np.inf
        moved = abs(multiplier - work.kept_multiplier[k, i]) - _ROUNDED * abs(multiplier)
        change = max(change, moved / work.scale[row])
        work.kept_row[k, i], work.kept_side[k, i] = row, active.side[i]
        work.kept_multiplier[k, i] = multiplier
    work.kept_size[k] = size
    return change


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
    negligible = NEGLIGIBLE if at.rank < 0 else _NEGLIGIBLE
    for _ in range(limit):
        work.iterations[0] += 1
        for k in range(size):
            target[k] = -active.d[k]
        solve_factored(active.F, target, size)
        gone, share = first_to_vanish(active, target, size, rows.is_equality, negligible)
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
def recentre(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    size: int,
    at: Coordinates,
) -> float:
    """Move the centre of the proximal cost to x; returns the gradient that it had there."""
    n, z, norm2, stop = work.x.size, linear.y, 0.0, at.stop
    for i in range(n):
        z[i] = work.x[i] - linear.center[i]
    reflect(linear, z, 0, stop)
    for c in range(stop):
        z[c] = 0.0
    for c in range(stop, n):
        norm2 += z[c] * z[c]
    reflect_back(linear, z, stop)
    for i in range(n):
        linear.center[i] += z[i]
    for k in range(size):
        row = active.row[k]
        value = value_of(rows, row, linear.center)
        active.d[k] = rows.ub[row] - value if active.side[k] > 0 else value - rows.lb[row]
    return math.sqrt(norm2) / (at.indifferent * at.indifferent)


@subkernel
def close_level(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    size: int,
    first: int,
) -> int:
    """Hold the rows that the level leans on; returns the first direction that is left."""
    n = work.x.size
    forced = _FORCED * largest_multiplier(active, work, size)
    for k in range(size):
        row, force = active.row[k], active.multiplier[k]
        work.used[row] = 0
        if force / work.scale[row] > forced:
            work.used[row] = 2
            if first < n:
                copy_row(rows, row, work.scale[row], linear.y)
                reflect(linear, linear.y, 0, first)
                s = 0.0
                for c in range(first, n):
                    s += linear.y[c] * linear.y[c]
                if s > 1e-14:
                    add_reflection(linear, linear.y, first, s)
                    first += 1
        elif work.softness[row] > 0.0:  # violated by no more than rounding
            if active.side[k] > 0:
                rows.ub[row] += work.softness[row] * force
            else:
                rows.lb[row] -= work.softness[row] * force
    for row in range(rows.lb.size):
        work.softness[row] = 0.0
    return first


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
    first = 0
    for k in range(last + 1):
        unit, stop, rank = 1.0, n, -1
        if k < last:
            if k == 0:
                count = put_equalities(rows, level, work, linear, first)
            else:
                count = starts[k] - starts[k - 1]
                unit = put_level(linear, G, starts[k - 1], starts[k], first)
            rank = factor_rows(linear, count, first)
            left = least_squares(linear, count, rank, first)
            stop = first + rank
            if k == 0:
                if left > _CONSISTENT * largest_of(linear.center):
                    return INFEASIBLE
                first = stop
                continue
            sensitive = 1.0
            for c in range(rank):
                sensitive = max(sensitive, 1.0 / abs(linear.A[c, first + c]))
            # The proximal cost must be small beside that of the level's weakest rows, too.
            indifferent = min(max(_SCALE, _ABOVE_SENSITIVE * sensitive), _LARGEST_SCALE)
            at = Coordinates(first, stop, rank, count > rank, indifferent, sensitive)
        else:
            if not reduce_cost(linear, H, g, first):
                return NOT_CONVEX
            sensitive, left = 0.0, n - first
            for c in range(left):
                sensitive = max(sensitive, square(linear.L, left)[c, c])
            at = Coordinates(first, n, rank, True, 1.0, sensitive)
        for row in range(lb.size):
            if level[row] == k:
                work.used[row] = 0
                work.softness[row] = 1.0 / (weight[row] * unit * unit)
        size = start_level(rows, active, work, linear, at, k - 1)
        outcome, gradient = SOLVED, 0.0
        for proximal_step in range(_PROXIMAL_STEPS):
            outcome, size = least_distance(rows, active, work, linear, at, size, tolerance, limit)
            if outcome != SOLVED:
                work.kept_size[k - 1] = 0
                return outcome
            change = keep(active, work, k - 1, size)
            if k == last:
                break
            before, gradient = gradient, recentre(rows, active, work, linear, size, at)
            error = _SENSITIVITY * gradient
            if proximal_step > 0 and gradient < before:  # which converges linearly
                error = min(error, change * gradient / (before - gradient))
            if error <= _CONVERGED * largest_multiplier(active, work, size):
                break
        work.unit[k - 1] = unit
        for i in range(n):
            linear.center[i] = work.x[i]
        if k < last:
            first = close_level(rows, active, work, linear, size, stop)
    return SOLVED

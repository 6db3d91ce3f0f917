"""The optimum of one level of a hierarchy, by a primal active-set method.

From a point x that holds all rows, and a working set of rows that it meets at their bounds, each
step solves

    min |A (x + d) − b|²   subject to   C_W d = 0

to rounding errors: Householder reflections take the rows C_W out of the coordinates, then those
of A (`wbc.qp.kernels.null_space`). The step ends where it meets another row, which joins the
working set; after a whole step the row with the most negative multiplier leaves it (Nocedal and
Wright, Numerical Optimization, 2006, §16.5). Violated rows that the level itself pays for are rows
of A as long as they are violated.

No cost is added that a direction of no cost would need in a dual method, so that rows which the
level does not lean on have multipliers of zero.
"""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import subkernel
from wbc.qp.kernels.dual_active_set import most_violated
from wbc.qp.kernels.level_memory import LevelWorkspace, copy_row, largest_multiplier
from wbc.qp.kernels.null_space import (
    LevelRows,
    add_reflection,
    factor_rows,
    least_squares,
    put_row,
    reflect,
    reflect_back,
)
from wbc.qp.kernels.working_set import Inequality, WorkingSet, remove, scale_of, value_of

_DEPENDENT = 5e-10  # share of a row that must be left to count as independent of those before it
_MOVED = 1e-9  # share of a step that must be across a row for the row to end it
_NEGATIVE = 1e-11  # negative multipliers that rounding may leave, for the largest
_FORCED = 1e-9  # multiplier of a row that a level holds on to, for the largest of them
_FREE = -np.inf


@subkernel
def hold_rows(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    first: int,
    size: int,
    least: float,
) -> int:
    """Take the exact rows of the working set out of the coordinates, from `first` on.

    Args:
        rows, active, work, linear, size: of the level.
        first: first coordinate that is left to the level.
        least: multiplier of the rows of norm one that count.

    Returns:
        The first coordinate that is left.
    """
    stop, n = first, work.x.size
    for k in range(size):
        row = active.row[k]
        work.column[k] = -1
        scale = abs(scale_of(rows, row, work.scale))
        if work.softness[row] > 0.0 or stop >= n:
            continue
        if active.multiplier[k] / scale < least:
            continue
        m, s = active.M[k], 0.0
        copy_row(rows, row, scale if active.side[k] > 0 else -scale, m)
        reflect(linear, m, 0, stop)
        for c in range(stop, n):
            s += m[c] * m[c]
        if s > _DEPENDENT * _DEPENDENT:
            add_reflection(linear, m, stop, s)
            work.column[k] = stop
            stop += 1
    return stop


@subkernel
def put_costs(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    G: np.ndarray,
    size: int,
    first: int,
    unit: float,
) -> int:
    """Make the residual rows G and the violated rows of the level those to be met.

    Returns:
        Their number.
    """
    n = work.x.size
    count: int = G.shape[0]
    for r in range(count):
        put_row(linear, r, G[r], G[r, n], unit, first)
    for k in range(size):
        row = active.row[k]
        if work.softness[row] > 0.0 and work.used[row] != 0:
            above = active.side[k] > 0
            copy_row(rows, row, 1.0 if above else -1.0, work.step)
            constant = -rows.ub[row] if above else rows.lb[row]
            put_row(linear, count, work.step, constant, 1.0 / math.sqrt(work.softness[row]), first)
            count += 1
    return count


@subkernel
def minimize_costs(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    G: np.ndarray,
    size: int,
    stop: int,
    unit: float,
) -> tuple[int, int]:
    """Move `linear.center` to the nearest least-squares solution of the level's costs.

    Args:
        rows, active, work, linear, G, size, unit: see `move_to_optimum`.
        stop: first coordinate that is free.

    Returns:
        The number of costs, and their rank in the free coordinates.
    """
    count = put_costs(rows, active, work, linear, G, size, stop, unit)
    rank = factor_rows(linear, count, stop)
    least_squares(linear, count, rank, stop)
    return count, rank


@subkernel
def find_multipliers(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    G: np.ndarray,
    size: int,
    first: int,
    stop: int,
    unit: float,
) -> None:
    """Compute the multipliers of the working set: Aᵀ (A x − b) + C_Wᵀ λ = 0."""
    x, g, n = work.x, linear.y, work.x.size
    if size == 0:
        return
    for i in range(n):
        g[i] = 0.0
    for r in range(G.shape[0]):
        s = G[r, n]
        for i in range(n):
            s += G[r, i] * x[i]
        s *= unit * unit
        for i in range(n):
            g[i] += s * G[r, i]
    for k in range(size):
        row = active.row[k]
        if work.softness[row] > 0.0:
            above = active.side[k] > 0
            y = value_of(rows, row, x)
            force = (y - rows.ub[row] if above else rows.lb[row] - y) / work.softness[row]
            active.multiplier[k] = force
            copy_row(rows, row, force if above else -force, work.step)
            for i in range(n):
                g[i] += work.step[i]
    reflect(linear, g, 0, stop)
    for k in range(size - 1, -1, -1):
        row, column = active.row[k], work.column[k]
        if work.softness[row] > 0.0:
            continue
        if column < 0:
            active.multiplier[k] = 0.0
            continue
        m = active.M[k]
        force = -g[column] / m[column]
        for c in range(first, column):
            g[c] += force * m[c]
        active.multiplier[k] = force * work.scale[row]


@subkernel
def first_to_block(
    rows: Inequality, active: WorkingSet, work: LevelWorkspace, size: int, tolerance: float
) -> tuple[int, int, int, float]:
    """Return which row ends the step `work.step` from x, and at what share of it.

    Of rows that end it at nearly the same share, the one that it crosses most directly.

    Returns:
        The row, −1 for none; the side; its place in the working set if it leaves it, else −1;
        the share, 1 for none.
    """
    x, d, rate = work.x, work.step, work.rate
    length = 0.0
    for s in d:
        length += s * s
    least = _MOVED * math.sqrt(length)
    latest = 1.0
    for row in range(rows.lb.size):
        rate[row] = 0.0
        if work.used[row] != 0:
            continue
        scale = scale_of(rows, row, work.scale)
        r = value_of(rows, row, d) * scale
        if scale < 0.0 or abs(r) <= least:
            continue
        bound = rows.ub[row] if r > 0.0 else rows.lb[row]
        if abs(bound) < 1e20:
            rate[row] = r
            gap = abs(r) / r * (bound - value_of(rows, row, x)) * scale
            latest = min(latest, (max(gap, 0.0) + tolerance) / abs(r))
    place, at, side, share, steepest = -1, -1, 0, 1.0, 0.0
    if latest < 1.0:
        for row in range(rows.lb.size):
            r = rate[row]
            if abs(r) <= steepest:
                continue
            bound = rows.ub[row] if r > 0.0 else rows.lb[row]
            gap = abs(r) / r * (bound - value_of(rows, row, x)) * work.scale[row]
            if max(gap, 0.0) <= latest * abs(r):
                at, side, steepest = row, 1 if r > 0.0 else -1, abs(r)
                share = max(gap, 0.0) / abs(r)
    for k in range(size):
        row = active.row[k]
        if work.softness[row] > 0.0:
            above = active.side[k] > 0
            r, y = value_of(rows, row, d), value_of(rows, row, x)
            if not above:
                r = -r
            off = y - rows.ub[row] if above else rows.lb[row] - y
            if r < 0.0 and max(off, 0.0) < -share * r:
                place, at, side, share = k, row, 0, max(off, 0.0) / -r
    return at, side, place, share


@subkernel
def repeat_level(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    G: np.ndarray,
    first: int,
    size: int,
    unit: float,
    tolerance: float,
) -> tuple[bool, int]:
    """Try whether the working set of the last solve is that of the optimum, too.

    Returns:
        Whether x is the optimum now; the first coordinate that neither the working set nor the
        level determines.
    """
    z, n = linear.product, work.x.size
    for i in range(n):
        work.x[i] = work.start[i]
        z[i] = 0.0
    stop = hold_rows(rows, active, work, linear, first, size, _FREE)
    for k in range(size):
        row, column = active.row[k], work.column[k]
        if work.softness[row] > 0.0:
            continue
        if column < 0:
            return False, stop
        y, m = value_of(rows, row, work.x), active.M[k]
        s = (rows.ub[row] - y if active.side[k] > 0 else y - rows.lb[row]) * work.scale[row]
        for c in range(first, column):
            s -= m[c] * z[c]
        z[column] = s / m[column]
    reflect_back(linear, z, stop)
    for i in range(n):
        linear.center[i] = work.x[i] + z[i]
    _, rank = minimize_costs(rows, active, work, linear, G, size, stop, unit)
    for i in range(n):
        work.x[i] = linear.center[i]
    if most_violated(rows, work, tolerance)[0] >= 0:
        return False, stop
    find_multipliers(rows, active, work, linear, G, size, first, stop, unit)
    least = -_NEGATIVE * largest_multiplier(active, work, size)
    for k in range(size):
        if active.multiplier[k] / work.scale[active.row[k]] < least:
            return False, stop
    return True, stop + rank


@subkernel
def move_to_optimum(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    G: np.ndarray,
    first: int,
    size: int,
    unit: float,
    tolerance: float,
    limit: int,
) -> tuple[bool, int, int]:
    """Move x to the optimum of the level.

    Args:
        rows, active, work, linear: of the level; x meets the working set and holds all rows.
        G: residual rows of the level.
        first: first coordinate that is left to the level.
        size: of the working set.
        unit: factor of G.
        tolerance: see `solve_levels`.
        limit: largest number of steps.

    Returns:
        Whether x is the optimum; the size of the working set; the first coordinate that
        neither the working set nor the level determines.
    """
    x, d, n = work.x, work.step, work.x.size
    for _ in range(limit):
        work.iterations[0] += 1
        stop = hold_rows(rows, active, work, linear, first, size, _FREE)
        for i in range(n):
            linear.center[i] = x[i]
        _, rank = minimize_costs(rows, active, work, linear, G, size, stop, unit)
        for i in range(n):
            d[i] = linear.center[i] - x[i]
        row, side, place, share = first_to_block(rows, active, work, size, tolerance)
        for i in range(n):
            x[i] = x[i] + share * d[i] if share < 1.0 else linear.center[i]
        if place >= 0:
            work.used[row] = 0
            remove(active, place, size)
            size -= 1
            continue
        if row >= 0:
            if size >= active.row.size:
                return False, size, stop + rank
            active.row[size], active.side[size] = row, side
            active.multiplier[size] = 0.0
            work.used[row] = 1
            size += 1
            continue
        find_multipliers(rows, active, work, linear, G, size, first, stop, unit)
        gone, worst = -1, -_NEGATIVE * largest_multiplier(active, work, size)
        for k in range(size):
            force = active.multiplier[k] / work.scale[active.row[k]]
            if force < worst:
                gone, worst = k, force
        if gone < 0:
            return True, size, stop + rank
        work.used[active.row[gone]] = 0
        remove(active, gone, size)
        size -= 1
    return False, size, first


@subkernel
def close_level(
    rows: Inequality,
    active: WorkingSet,
    work: LevelWorkspace,
    linear: LevelRows,
    G: np.ndarray,
    first: int,
    size: int,
    stop: int,
    unit: float,
) -> int:
    """Hold the rows that the level leans on; returns the first coordinate that is left.

    Args:
        rows, active, work, linear, G, first, size, unit: see `move_to_optimum`.
        stop: first coordinate that neither the working set nor the level determines.
    """
    forced = _FORCED * largest_multiplier(active, work, size)
    all_held = True
    for k in range(size):
        row, force = active.row[k], active.multiplier[k]
        if force / work.scale[row] > forced:
            work.used[row] = 2
            continue
        work.used[row] = 0
        if work.softness[row] > 0.0:  # violated by no more than rounding
            all_held = False
            if active.side[k] > 0:
                rows.ub[row] += max(work.softness[row] * force, 0.0)
            else:
                rows.lb[row] -= max(work.softness[row] * force, 0.0)
        elif work.column[k] >= 0:
            all_held = False
    if not all_held:
        stop = hold_rows(rows, active, work, linear, first, size, forced)
        for i in range(work.x.size):
            linear.center[i] = work.x[i]
        count = put_costs(rows, active, work, linear, G, size, stop, unit)
        stop += factor_rows(linear, count, stop)
    return stop

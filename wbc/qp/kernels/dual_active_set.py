"""A dual active-set method for small dense strictly convex QPs that follow one another.

    min ½ xᵀ H x + gᵀ x   subject to   lb ≤ [x[:bounded]; C x] ≤ ub

With H = L Lᵀ, w = L⁻¹ g and y = Lᵀ x + w the cost is ½ |y|², and a row c x ≤ u reads
m·y ≤ d for m = L⁻¹ c, d = u + m·w. For a working set of rows held at their bounds the
multipliers solve K λ = −d with K = M Mᵀ, and y = −Mᵀ λ. Starting from any set with λ ≥ 0, such as
that of the last tick, rows are added (the most violated one) and removed (the one whose
multiplier would change sign first) until neither is needed; the dual cost rises at each step
(Goldfarb and Idnani, A numerically stable dual method for solving strictly convex quadratic
programs, Mathematical Programming 1983; the start from any set as in Arnström, Bemporad and
Axehill, A dual active-set solver for embedded quadratic programming using recursive LDLᵀ
updates, IEEE TAC 2022).

Only rows in the working set are ever transformed: a tick with three active rows costs one
Cholesky factorisation, one product C x per step and little else.
"""

from __future__ import annotations

import numpy as np

from wbc.jit.compile import kernel, subkernel
from wbc.qp.kernels.factors import cholesky, solve_factored, solve_lower, solve_lower_transposed
from wbc.qp.kernels.schema import reader
from wbc.qp.kernels.working_set import (
    Inequality,
    RowMemory,
    WorkingSet,
    Workspace,
    append,
    exchange,
    refactor,
    remove,
    scale_of,
    start_from_last,
    value_of,
)

SOLVED, INFEASIBLE, ITERATION_LIMIT, NOT_CONVEX, NOT_EXACT = 0, 1, 2, 3, 4

NEGLIGIBLE = 1e-13  # share of the largest multiplier that rounding errors may have

SOLVER_GROUPS = (WorkingSet, Workspace)
_read_working_set = reader(SOLVER_GROUPS, WorkingSet)
_read_workspace = reader(SOLVER_GROUPS, Workspace)


@subkernel
def point_of(active: WorkingSet, work: Workspace, size: int) -> None:
    """Compute x of the multipliers: Lᵀ x = −Mᵀ λ − w."""
    x, n = work.x, work.x.size
    for i in range(n):
        x[i] = -work.w[i]
    for k in range(size):
        factor = active.multiplier[k]
        for i in range(n):
            x[i] -= factor * active.M[k, i]
    solve_lower_transposed(work.L, x, x.size)


@subkernel
def most_violated(rows: Inequality, work: RowMemory, tolerance: float) -> tuple[int, int]:
    """Return the row that is violated most for its scale, and the side; (−1, 0) when none is."""
    worst, at, side = tolerance, -1, 0
    for row in range(rows.lb.size):
        if work.used[row] != 0:
            continue
        y = value_of(rows, row, work.x)
        above, below = y - rows.ub[row], rows.lb[row] - y
        if above > 0.0 and above * abs(scale_of(rows, row, work.scale)) > worst:
            worst, at, side = above * abs(work.scale[row]), row, 1
        if below > 0.0 and below * abs(scale_of(rows, row, work.scale)) > worst:
            worst, at, side = below * abs(work.scale[row]), row, -1
    return at, side


@subkernel
def first_to_vanish(
    active: WorkingSet,
    target: np.ndarray,
    size: int,
    is_equality: np.ndarray,
    negligible: float,
) -> tuple[int, float]:
    """Return which multiplier changes sign first on the way to the target, and at what share.

    Negative ones count from the negligible share of the largest on.
    """
    largest = 0.0
    for k in range(size):
        largest = max(largest, abs(target[k]))
    at, share = -1, 1.0
    for k in range(size):
        if is_equality[active.row[k]] or target[k] >= -negligible * largest:
            continue
        s = active.multiplier[k] / (active.multiplier[k] - target[k])
        if s < share:
            at, share = k, s
    return at, share


@subkernel
def refine(
    rows: Inequality, active: WorkingSet, work: Workspace, size: int, tolerance: float
) -> float:
    """Bring the rows of the working set to their bounds up to rounding errors.

    Returns:
        By how much one of them is off, for its scale.
    """
    x, residual, step, n = work.x, work.residual, work.step, work.x.size
    worst = 0.0
    for attempt in range(4):
        worst = 0.0
        for k in range(size):
            row = active.row[k]
            y = value_of(rows, row, x)
            residual[k] = y - rows.ub[row] if active.side[k] > 0 else rows.lb[row] - y
            worst = max(worst, abs(residual[k]) * scale_of(rows, row, work.scale))
        if not worst > 0.05 * tolerance or attempt == 3:
            return worst
        solve_factored(active.F, residual, size)
        # A correction of x itself: x of the multipliers again would carry the rounding errors
        # of large multipliers that all but cancel.
        for i in range(n):
            step[i] = 0.0
        for k in range(size):
            active.multiplier[k] += residual[k]
            for i in range(n):
                step[i] += residual[k] * active.M[k, i]
        solve_lower_transposed(work.L, step, n)
        for i in range(n):
            x[i] -= step[i]
    return worst


@kernel(
    "int64(float64[:,::1], float64[::1], float64[:,::1], float64[::1], float64[::1], int64, "
    "boolean[::1], float64, int64, float64[::1], int64[::1], int64[:,::1])"
)
def solve(
    H: np.ndarray,
    g: np.ndarray,
    C: np.ndarray,
    lb: np.ndarray,
    ub: np.ndarray,
    bounded: int,
    is_equality: np.ndarray,
    tolerance: float,
    limit: int,
    real_arrays: np.ndarray,
    integer_arrays: np.ndarray,
    table: np.ndarray,
) -> int:
    """Solve; the solution is left in `Workspace.x`.

    Args:
        H, g, C, lb, ub: the problem; n unknowns, r rows.
        bounded: number of simple bounds, on the first unknowns.
        is_equality: (r,).
        tolerance: by how much a row of unit norm may be violated.
        limit: largest number of iterations.
        real_arrays, integer_arrays, table: the arrays of a `Memory` of `SOLVER_GROUPS`.

    Returns:
        SOLVED, INFEASIBLE, ITERATION_LIMIT, NOT_CONVEX or NOT_EXACT: rounding errors keep the
        working set from its bounds.
    """
    active = _read_working_set(real_arrays, integer_arrays, table)
    work = _read_workspace(real_arrays, integer_arrays, table)
    rows = Inequality(C, lb, ub, bounded, is_equality)
    target, w = work.target, work.w
    if not cholesky(H, work.L):
        return NOT_CONVEX
    for k in range(g.size):
        w[k] = g[k]
    solve_lower(work.L, w, np.int64(0))
    size = start_from_last(rows, active, work)
    outcome = ITERATION_LIMIT
    iteration = 0
    while iteration < limit:
        iteration += 1
        for k in range(size):
            target[k] = -active.d[k]
        solve_factored(active.F, target, size)
        at, share = first_to_vanish(active, target, size, is_equality, NEGLIGIBLE)
        if at >= 0:
            for k in range(size):
                active.multiplier[k] += share * (target[k] - active.multiplier[k])
            work.used[active.row[at]] = 0
            remove(active, at, size)
            size = refactor(active, work, at, size - 1, 0)
            continue
        for k in range(size):
            active.multiplier[k] = target[k]
        point_of(active, work, size)
        off = refine(rows, active, work, size, tolerance)
        row, side = most_violated(rows, work, tolerance)
        if row < 0:
            outcome = SOLVED if off <= tolerance else NOT_EXACT
            break
        if work.scale[row] < 0.0:
            outcome = INFEASIBLE
            break
        append(rows, active, work, row, side, size)
        active.multiplier[size] = 0.0
        size = exchange(rows, active, work, size)
        if size < 0:
            size = 0
            outcome = INFEASIBLE
            break
        work.used[row] = 1
        size += 1
    active.size[0], active.iterations[0] = size, iteration
    return outcome

"""A dual active-set method for small dense strictly convex QPs that follow one another.

    min ½ xᵀ H x + gᵀ x   subject to   lb ≤ [x[:bounded]; C x] ≤ ub

With H = L Lᵀ, w = L⁻¹ g and y = Lᵀ x + w the cost is ½ |y|², and a row c x ≤ u reads
m·y ≤ d for m = L⁻¹ c, d = u + m·w. For a working set of rows held at their bounds the
multipliers solve K λ = −d with K = M Mᵀ, and y = −Mᵀ λ. Starting from any set with λ ≥ 0, that
of the last tick say, rows are added (the most violated one) and removed (the one whose
multiplier would change sign first) until neither is needed; the dual cost rises at each step
(Goldfarb and Idnani, A numerically stable dual method for solving strictly convex quadratic
programs, Mathematical Programming 1983; the start from any set as in Arnström, Bemporad and
Axehill, A dual active-set solver for embedded quadratic programming using recursive LDLᵀ
updates, IEEE TAC 2022).

Only rows in the working set are ever transformed: a tick with three active rows costs one
Cholesky factorisation, one product C x per step and little else.
"""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import kernel, subkernel
from wbc.qp.kernels.factors import (
    backward,
    cholesky,
    factor_row,
    forward,
    solve_factored,
)

SOLVED, INFEASIBLE, ITERATION_LIMIT, NOT_CONVEX, NOT_EXACT = 0, 1, 2, 3, 4

_NOTHING = 1e-9  # norm of a row that is none


@subkernel
def transformed_row(
    C: np.ndarray, L: np.ndarray, bounded: int, row: int, sign: float, m: np.ndarray
) -> None:
    """m = sign L⁻¹ c."""
    for k in range(m.size):
        m[k] = 0.0
    if row < bounded:
        m[row] = sign
        forward(L, m, row)
    else:
        for k in range(m.size):
            m[k] = sign * C[row - bounded, k]
        forward(L, m, np.int64(0))  # a literal would be compiled apart


@subkernel
def append(
    C: np.ndarray,
    L: np.ndarray,
    w: np.ndarray,
    lb: np.ndarray,
    ub: np.ndarray,
    bounded: int,
    row: int,
    side: int | np.int64,
    k: int,
    rows: np.ndarray,
    sides: np.ndarray,
    M: np.ndarray,
    K: np.ndarray,
    d: np.ndarray,
) -> None:
    """Put a row at place k of the working set; the factor is left to `factor_row`."""
    n = w.size
    sign = 1.0 if side > 0 else -1.0
    rows[k], sides[k] = row, side
    transformed_row(C, L, bounded, row, sign, M[k])
    s = ub[row] if side > 0 else -lb[row]
    for i in range(n):
        s += M[k, i] * w[i]
    d[k] = s
    for j in range(k + 1):
        s = 0.0
        for i in range(n):
            s += M[k, i] * M[j, i]
        K[k, j] = s


@subkernel
def remove(
    at: int,
    size: int,
    rows: np.ndarray,
    sides: np.ndarray,
    M: np.ndarray,
    K: np.ndarray,
    d: np.ndarray,
    multipliers: np.ndarray,
) -> None:
    """Take the row at a place out of the working set."""
    n = M.shape[1]
    for k in range(at, size - 1):
        rows[k], sides[k] = rows[k + 1], sides[k + 1]
        d[k], multipliers[k] = d[k + 1], multipliers[k + 1]
        for i in range(n):
            M[k, i] = M[k + 1, i]
        for j in range(at):
            K[k, j] = K[k + 1, j]
        for j in range(at, k + 1):
            K[k, j] = K[k + 1, j + 1]


@subkernel
def refactor(
    at: int,
    size: int,
    pending: int,
    rows: np.ndarray,
    sides: np.ndarray,
    M: np.ndarray,
    K: np.ndarray,
    F: np.ndarray,
    d: np.ndarray,
    multipliers: np.ndarray,
    used: np.ndarray,
) -> int:
    """Factor the rows from `at` on again, leaving out what rounding made dependent.

    Args:
        at: first row that changed.
        size: rows of the working set.
        pending: rows behind them that are not factored yet.

    Returns:
        The size that is left.
    """
    i = at
    while i < size:
        if factor_row(K, F, i):
            i += 1
        else:
            used[rows[i]] = 0
            remove(i, size + pending, rows, sides, M, K, d, multipliers)
            size -= 1
    return size


@subkernel
def point_of(
    L: np.ndarray, M: np.ndarray, multipliers: np.ndarray, size: int, w: np.ndarray, x: np.ndarray
) -> None:
    """x of the multipliers: L x = −Mᵀ λ − w, transposed."""
    n = x.size
    for i in range(n):
        x[i] = -w[i]
    for k in range(size):
        for i in range(n):
            x[i] -= multipliers[k] * M[k, i]
    backward(L, x, n)


@subkernel
def scale_of(row: int, C: np.ndarray, bounded: int, scale: np.ndarray) -> float:
    """One over the norm of a row, found when it is first asked for.

    Negative for a row of which elimination left nothing but rounding errors: it holds, or does
    not, whatever x.
    """
    if scale[row] == 0.0:
        s = 1.0
        if row >= bounded:
            s = 0.0
            for c in C[row - bounded]:
                s += c * c
        scale[row] = 1.0 / math.sqrt(s) if s > _NOTHING * _NOTHING else -1.0
    known: float = scale[row]
    return known


@subkernel
def most_violated(
    C: np.ndarray,
    x: np.ndarray,
    lb: np.ndarray,
    ub: np.ndarray,
    bounded: int,
    scale: np.ndarray,
    used: np.ndarray,
    tolerance: float,
) -> tuple[int, int]:
    """Row whose bound is violated most for its scale, and the side; (−1, 0) when none is."""
    worst, at, side = tolerance, -1, 0
    for row in range(lb.size):
        if used[row] != 0:
            continue
        if row < bounded:
            y = x[row]
        else:
            y = 0.0
            for k in range(x.size):
                y += C[row - bounded, k] * x[k]
        above, below = y - ub[row], lb[row] - y
        if above > 0.0 and above * abs(scale_of(row, C, bounded, scale)) > worst:
            worst, at, side = above * abs(scale[row]), row, 1
        if below > 0.0 and below * abs(scale_of(row, C, bounded, scale)) > worst:
            worst, at, side = below * abs(scale[row]), row, -1
    return at, side


@subkernel
def first_to_vanish(
    multipliers: np.ndarray,
    wanted: np.ndarray,
    sides: np.ndarray,
    size: int,
    is_equality: np.ndarray,
    rows: np.ndarray,
) -> tuple[int, float]:
    """Which multiplier changes sign first on the way to the wanted ones, and after what share."""
    largest = 0.0
    for k in range(size):
        largest = max(largest, abs(wanted[k]))
    at, share = -1, 1.0
    for k in range(size):
        if is_equality[rows[k]] or wanted[k] >= -1e-13 * largest:
            continue
        s = multipliers[k] / (multipliers[k] - wanted[k])
        if s < share:
            at, share = k, s
    return at, share


@subkernel
def refine(
    C: np.ndarray,
    L: np.ndarray,
    F: np.ndarray,
    M: np.ndarray,
    lb: np.ndarray,
    ub: np.ndarray,
    bounded: int,
    rows: np.ndarray,
    sides: np.ndarray,
    size: int,
    scale: np.ndarray,
    tolerance: float,
    x: np.ndarray,
    multipliers: np.ndarray,
    r: np.ndarray,
    step: np.ndarray,
) -> float:
    """Bring the rows of the working set to their bounds up to rounding errors.

    Returns:
        By how much one of them is off, for its scale.
    """
    n = x.size
    worst = 0.0
    for attempt in range(4):
        worst = 0.0
        for k in range(size):
            row = rows[k]
            if row < bounded:
                y = x[row]
            else:
                y = 0.0
                for i in range(n):
                    y += C[row - bounded, i] * x[i]
            r[k] = y - ub[row] if sides[k] > 0 else lb[row] - y
            worst = max(worst, abs(r[k]) * scale_of(row, C, bounded, scale))
        if not worst > 0.05 * tolerance or attempt == 3:
            return worst
        solve_factored(F, r, size)
        # A correction of x itself: x of the multipliers again would carry the rounding errors
        # of large multipliers that all but cancel.
        for i in range(n):
            step[i] = 0.0
        for k in range(size):
            multipliers[k] += r[k]
            for i in range(n):
                step[i] += r[k] * M[k, i]
        backward(L, step, n)
        for i in range(n):
            x[i] -= step[i]
    return worst


@kernel(
    "int64(float64[:,::1], float64[::1], float64[:,::1], float64[::1], float64[::1], int64, "
    "boolean[::1], float64, int64, int64[::1], int64[::1], int64[::1], float64[::1], "
    "float64[:,:,::1], float64[:,::1])"
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
    counts: np.ndarray,
    rows: np.ndarray,
    sides: np.ndarray,
    multipliers: np.ndarray,
    square: np.ndarray,
    line: np.ndarray,
) -> int:
    """Solve; the solution is left in line[0][:n].

    Args:
        H, g, C, lb, ub: the problem; n unknowns, r rows.
        bounded: number of simple bounds, on the first unknowns.
        is_equality: (r,).
        tolerance: by how much a row of unit norm may be violated.
        limit: of iterations.
        counts: size of the working set before and after; iterations.
        rows, sides: (n + 1,) working set: rows of lb and ub, and +1 at ub or −1 at lb.
        multipliers: (n + 1,).
        square: (4, n + 1, n + 1) room for L, M, K and F.
        line: (5, r + 2 n + 2) room for x and others.

    Returns:
        SOLVED, INFEASIBLE, ITERATION_LIMIT, NOT_CONVEX or NOT_EXACT: rounding errors keep the
        working set from its bounds.
    """
    n, total = g.size, lb.size
    L, M, K, F = square[0, :n, :n], square[1, :, :n], square[2], square[3]
    x, w, wanted, d, scale = line[0, :n], line[1, :n], line[2], line[3], line[4, :total]
    r = line[1, n:]
    if not cholesky(H, L):
        return NOT_CONVEX
    for k in range(n):
        w[k] = g[k]
    forward(L, w, np.int64(0))
    used = np.zeros(total, np.int8)
    for row in range(total):
        scale[row] = 0.0
    # Equalities first, then what was active before.
    before = counts[0]
    old_rows, old_sides, old_multipliers = rows.copy(), sides.copy(), multipliers.copy()
    size = 0
    for row in range(total):
        if is_equality[row] and size <= n and scale_of(row, C, bounded, scale) > 0.0:
            append(C, L, w, lb, ub, bounded, row, np.int64(1), size, rows, sides, M, K, d)
            if size < n and factor_row(K, F, size):
                used[row] = 1
                multipliers[size] = 0.0
                size += 1
    for k in range(before):
        row = old_rows[k]
        if is_equality[row] or used[row] != 0 or size >= n:
            continue
        bound = ub[row] if old_sides[k] > 0 else lb[row]
        if not abs(bound) < 1e20:
            continue
        append(C, L, w, lb, ub, bounded, row, old_sides[k], size, rows, sides, M, K, d)
        if factor_row(K, F, size):
            used[row] = 1
            multipliers[size] = max(old_multipliers[k], 0.0)
            size += 1
    outcome = ITERATION_LIMIT
    iteration = 0
    while iteration < limit:
        iteration += 1
        for k in range(size):
            wanted[k] = -d[k]
        solve_factored(F, wanted, size)
        at, share = first_to_vanish(multipliers, wanted, sides, size, is_equality, rows)
        if at >= 0:
            for k in range(size):
                multipliers[k] += share * (wanted[k] - multipliers[k])
            used[rows[at]] = 0
            remove(at, size, rows, sides, M, K, d, multipliers)
            size = refactor(at, size - 1, 0, rows, sides, M, K, F, d, multipliers, used)
            continue
        for k in range(size):
            multipliers[k] = wanted[k]
        point_of(L, M, multipliers, size, w, x)
        off = refine(
            C,
            L,
            F,
            M,
            lb,
            ub,
            bounded,
            rows,
            sides,
            size,
            scale,
            tolerance,
            x,
            multipliers,
            r,
            wanted,
        )
        row, side = most_violated(C, x, lb, ub, bounded, scale, used, tolerance)
        if row < 0:
            outcome = SOLVED if off <= tolerance else NOT_EXACT
            break
        if scale[row] < 0.0:
            outcome = INFEASIBLE
            break
        append(C, L, w, lb, ub, bounded, row, side, size, rows, sides, M, K, d)
        multipliers[size] = 0.0
        while size >= n or not factor_row(K, F, size):
            # The new row is a combination z of the others: trade it for one of them.
            for k in range(size):
                wanted[k] = K[size, k]
            solve_factored(F, wanted, size)
            at, share = -1, np.inf
            for k in range(size):
                if not is_equality[rows[k]] and wanted[k] > 1e-9:
                    s = multipliers[k] / wanted[k]
                    if s < share:
                        at, share = k, s
            if at < 0:
                outcome = INFEASIBLE
                break
            for k in range(size):
                multipliers[k] -= share * wanted[k]
            multipliers[size] += share
            used[rows[at]] = 0
            remove(at, size + 1, rows, sides, M, K, d, multipliers)
            size = refactor(at, size - 1, 1, rows, sides, M, K, F, d, multipliers, used)
        if outcome == INFEASIBLE:
            break
        used[row] = 1
        size += 1
    counts[0], counts[1] = size, iteration
    return outcome

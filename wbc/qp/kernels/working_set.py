"""The working set of the dual active-set method: rows that are held at one of their bounds.

The symbols are those of `wbc.qp.kernels.dual_active_set`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple, Protocol

import numpy as np

from wbc.jit.compile import subkernel
from wbc.qp.kernels.factors import factor_row, solve_factored, solve_lower
from wbc.qp.kernels.schema import integers, reals

_ZERO_NORM = 1e-9  # norm below which a row has no direction


class WorkingSet(NamedTuple):
    """Rows that are held at one of their bounds. It carries over from solve to solve.

    Attributes:
        size: number of rows.
        iterations: number of iterations of the last solve.
        row: row of lb and ub.
        side: +1 at the upper bound, −1 at the lower.
        multiplier: λ.
        M: m of each row.
        K: M Mᵀ, lower triangle.
        F: lower factor of K.
        d: right sides.
    """

    size: Annotated[np.ndarray, integers(1)]
    iterations: Annotated[np.ndarray, integers(1)]
    row: Annotated[np.ndarray, integers("capacity")]
    side: Annotated[np.ndarray, integers("capacity")]
    multiplier: Annotated[np.ndarray, reals("capacity")]
    M: Annotated[np.ndarray, reals("capacity", "unknowns")]
    K: Annotated[np.ndarray, reals("capacity", "capacity")]
    F: Annotated[np.ndarray, reals("capacity", "capacity")]
    d: Annotated[np.ndarray, reals("capacity")]


class Workspace(NamedTuple):
    """Memory of one solve.

    Attributes:
        x: the solution.
        L: lower factor of H.
        w: L⁻¹ g.
        scale: one over the norm of each row, see `scale_of`.
        used: 1 for rows in the working set.
        target: multipliers at which all rows of the working set meet their bounds.
        residual: by how much the rows of the working set miss their bounds.
        step: correction of x.
        old_row: the working set of the last solve, likewise old_side and old_multiplier.
    """

    x: Annotated[np.ndarray, reals("unknowns")]
    L: Annotated[np.ndarray, reals("unknowns", "unknowns")]
    w: Annotated[np.ndarray, reals("unknowns")]
    scale: Annotated[np.ndarray, reals("rows")]
    used: Annotated[np.ndarray, integers("rows")]
    target: Annotated[np.ndarray, reals("capacity")]
    residual: Annotated[np.ndarray, reals("capacity")]
    step: Annotated[np.ndarray, reals("unknowns")]
    old_row: Annotated[np.ndarray, integers("capacity")]
    old_side: Annotated[np.ndarray, integers("capacity")]
    old_multiplier: Annotated[np.ndarray, reals("capacity")]


class RowMemory(Protocol):
    """What the steps on a working set need of a solver's memory; see `Workspace`."""

    @property
    def x(self) -> np.ndarray: ...
    @property
    def scale(self) -> np.ndarray: ...
    @property
    def used(self) -> np.ndarray: ...
    @property
    def target(self) -> np.ndarray: ...


class Inequality(NamedTuple):
    """`lb ≤ [x[:bounded]; C x] ≤ ub`, see `wbc.qp.problem`."""

    C: np.ndarray
    lb: np.ndarray
    ub: np.ndarray
    bounded: int
    is_equality: np.ndarray


@subkernel
def value_of(rows: Inequality, row: int, x: np.ndarray) -> float:
    """Return what the bounds of a row are compared with at x."""
    if row < rows.bounded:
        y: float = x[row]
        return y
    y = 0.0
    for k in range(x.size):
        y += rows.C[row - rows.bounded, k] * x[k]
    return y


@subkernel
def scale_of(rows: Inequality, row: int, scale: np.ndarray) -> float:
    """Return one over the norm of a row, computed on first use.

    Negative for a row of which elimination left only rounding errors: whether it holds does not
    depend on x.
    """
    if scale[row] == 0.0:
        s = 1.0
        if row >= rows.bounded:
            s = 0.0
            for c in rows.C[row - rows.bounded]:
                s += c * c
        scale[row] = 1.0 / math.sqrt(s) if s > _ZERO_NORM * _ZERO_NORM else -1.0
    factor: float = scale[row]
    return factor


@subkernel
def append(
    rows: Inequality, active: WorkingSet, work: Workspace, row: int, side: int | np.int64, k: int
) -> None:
    """Put a row at place k of the working set; the factor is left to `factor_row`."""
    n = work.w.size
    sign = 1.0 if side > 0 else -1.0
    active.row[k], active.side[k] = row, side
    m = active.M[k]
    if row < rows.bounded:
        for i in range(n):
            m[i] = 0.0
        m[row] = sign
        solve_lower(work.L, m, row)
    else:
        c = rows.C[row - rows.bounded]
        for i in range(n):
            m[i] = sign * c[i]
        first = np.int64(0)  # a literal would be compiled apart
        while first < n - 1 and c[first] == 0.0:
            first += 1
        solve_lower(work.L, m, first)
    s = rows.ub[row] if side > 0 else -rows.lb[row]
    for i in range(n):
        s += m[i] * work.w[i]
    active.d[k] = s
    for j in range(k + 1):
        s = 0.0
        for i in range(n):
            s += m[i] * active.M[j, i]
        active.K[k, j] = s


@subkernel
def remove(active: WorkingSet, at: int, size: int) -> None:
    """Take the row at a place out of the working set."""
    n = active.M.shape[1]
    for k in range(at, size - 1):
        active.row[k], active.side[k] = active.row[k + 1], active.side[k + 1]
        active.d[k], active.multiplier[k] = active.d[k + 1], active.multiplier[k + 1]
        for i in range(n):
            active.M[k, i] = active.M[k + 1, i]
        for j in range(at):
            active.K[k, j] = active.K[k + 1, j]
        for j in range(at, k + 1):
            active.K[k, j] = active.K[k + 1, j + 1]


@subkernel
def refactor(active: WorkingSet, work: RowMemory, at: int, size: int, pending: int) -> int:
    """Factor the rows from `at` on again, leaving out what rounding made dependent.

    Args:
        active: the working set.
        work: memory.
        at: first row that changed.
        size: rows of the working set.
        pending: rows behind them that are not factored yet.

    Returns:
        The size that is left.
    """
    i = at
    while i < size:
        if factor_row(active.K, active.F, i):
            i += 1
        else:
            work.used[active.row[i]] = 0
            remove(active, i, size + pending)
            size -= 1
    return size


@subkernel
def start_from_last(rows: Inequality, active: WorkingSet, work: Workspace) -> int:
    """Fill the working set with the equalities, then with what was active before.

    Returns:
        Its size.
    """
    n, total = work.x.size, rows.lb.size
    before = active.size[0]
    for k in range(before):
        work.old_row[k], work.old_side[k] = active.row[k], active.side[k]
        work.old_multiplier[k] = active.multiplier[k]
    for row in range(total):
        work.scale[row] = 0.0
        work.used[row] = 0
    size = 0
    for row in range(total):
        if rows.is_equality[row] and size <= n and scale_of(rows, row, work.scale) > 0.0:
            append(rows, active, work, row, np.int64(1), size)
            if size < n and factor_row(active.K, active.F, size):
                work.used[row] = 1
                active.multiplier[size] = 0.0
                size += 1
    for k in range(before):
        row, side = work.old_row[k], work.old_side[k]
        if rows.is_equality[row] or work.used[row] != 0 or size >= n:
            continue
        bound = rows.ub[row] if side > 0 else rows.lb[row]
        if not abs(bound) < 1e20:
            continue
        append(rows, active, work, row, side, size)
        if factor_row(active.K, active.F, size):
            work.used[row] = 1
            active.multiplier[size] = max(work.old_multiplier[k], 0.0)
            size += 1
    return size


@subkernel
def exchange(rows: Inequality, active: WorkingSet, work: RowMemory, size: int) -> int:
    """Make the row behind the working set independent of it, trading it for others if needed.

    While the new row is a combination z of the others, one of those leaves: the one whose
    multiplier vanishes first.

    Returns:
        The size without the new row; −1 when no row can leave, so that no point holds them all.
    """
    full, target = active.row.size - 1, work.target
    while size >= full or not factor_row(active.K, active.F, size):
        for k in range(size):
            target[k] = active.K[size, k]
        solve_factored(active.F, target, size)
        at, share = -1, np.inf
        for k in range(size):
            if not rows.is_equality[active.row[k]] and target[k] > 1e-9:
                s = active.multiplier[k] / target[k]
                if s < share:
                    at, share = k, s
        if at < 0:
            return -1
        for k in range(size):
            active.multiplier[k] -= share * target[k]
        active.multiplier[size] += share
        work.used[active.row[at]] = 0
        remove(active, at, size + 1)
        size = refactor(active, work, at, size - 1, 1)
    return size

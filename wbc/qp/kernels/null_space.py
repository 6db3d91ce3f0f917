"""The coordinates of a level: what its rows determine, and what is left to lower levels.

Householder reflections from the right turn the rows of one level after the other into a lower
triangle (Golub and Van Loan, Matrix Computations, 2013, §5.4). In z = Qᵀ (x − x̄), Q their
product, the entries before `first` are determined by higher levels, and the level's rows read

    A x + r = [L₁; X L₁] z[first:stop] + …,    L₁ square, lower triangular and regular:

rows are taken in the order of what is left of them, and X belongs to those that follow from
others. The entries from `stop` on span the null space. Q is never formed.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from wbc.jit.compile import subkernel
from wbc.qp.kernels.factors import cholesky, solve_lower, solve_lower_transposed
from wbc.qp.kernels.schema import reals

_RANK = 1e-9  # share of a row that must be left to count as independent of higher levels
_ZERO_NORM = 1e-10  # norm below which a row has no direction


class LevelRows(NamedTuple):
    """The rows of one level, and the reflections of this and all higher ones.

    Attributes:
        A: the rows times Q, factored in place.
        residual: r = A x̄ − b.
        norm2: squared norms of the rows.
        V: reflection j is I − factor[j] V[j] V[j]ᵀ; its entries before j are zero.
        factor: one per reflection.
        center: x̄.
        H: Hessian of the level in its own coordinates.
        L: its Cholesky factor with reciprocal diagonal, at the beginning of this memory.
        y: coordinates.
        product: work.
    """

    A: Annotated[np.ndarray, reals("level_rows", "unknowns")]
    residual: Annotated[np.ndarray, reals("level_rows")]
    norm2: Annotated[np.ndarray, reals("level_rows")]
    V: Annotated[np.ndarray, reals("unknowns", "unknowns")]
    factor: Annotated[np.ndarray, reals("unknowns")]
    center: Annotated[np.ndarray, reals("unknowns")]
    H: Annotated[np.ndarray, reals("unknowns", "unknowns")]
    L: Annotated[np.ndarray, reals("unknowns", "unknowns")]
    y: Annotated[np.ndarray, reals("unknowns")]
    product: Annotated[np.ndarray, reals("unknowns")]


@subkernel
def square(memory: np.ndarray, size: int) -> np.ndarray:
    """Return the beginning of a matrix's memory as a square matrix of another size."""
    matrix: np.ndarray = memory.reshape(-1)[: size * size].reshape((size, size))
    return matrix


@subkernel
def reflect(rows: LevelRows, z: np.ndarray, begin: int, end: int) -> None:
    """z ← z times the reflections from one to another."""
    n = z.size
    for j in range(begin, end):
        v, s = rows.V[j], 0.0
        for c in range(j, n):
            s += z[c] * v[c]
        s *= rows.factor[j]
        for c in range(j, n):
            z[c] -= s * v[c]


@subkernel
def reflect_back(rows: LevelRows, z: np.ndarray, count: int) -> None:
    """z ← Q z."""
    n = z.size
    for j in range(count - 1, -1, -1):
        v, s = rows.V[j], 0.0
        for c in range(j, n):
            s += z[c] * v[c]
        s *= rows.factor[j]
        for c in range(j, n):
            z[c] -= s * v[c]


@subkernel
def add_reflection(rows: LevelRows, row: np.ndarray, j: int, norm2: float) -> None:
    """Make reflection j the one that turns a row's entries from j on into a multiple of e_j."""
    v, n = rows.V[j], row.size
    head = row[j]
    to = -math.copysign(math.sqrt(norm2), head)
    for c in range(j, n):
        v[c] = row[c]
        row[c] = 0.0
    v[j] = head - to
    row[j] = to
    rows.factor[j] = 1.0 / (norm2 - head * to)


@subkernel
def put_row(
    rows: LevelRows, k: int, a: np.ndarray, constant: float, factor: float, first: int
) -> None:
    """Row k ← factor (a x̂) in the coordinates of the level, with its value at x̄ for a residual.

    Args:
        rows: the level.
        k: which.
        a: coefficients of x, at least n of them.
        constant: what is added to a x.
        factor: scale.
        first: number of reflections.
    """
    out = rows.A[k]
    n, value, norm2 = out.size, constant, 0.0
    for i in range(n):
        value += a[i] * rows.center[i]
        out[i] = factor * a[i]
        norm2 += out[i] * out[i]
    rows.residual[k] = factor * value
    if norm2 < (_ZERO_NORM * factor) ** 2:  # only rounding errors are left of it
        norm2 = 0.0
        for i in range(n):
            out[i] = 0.0
    else:
        reflect(rows, out, 0, first)
    rows.norm2[k] = norm2


@subkernel
def factor_rows(rows: LevelRows, size: int, first: int) -> int:
    """Bring the rows to lower triangular form and return their rank."""
    A = rows.A
    n = A.shape[1]
    rank = 0
    while rank < size and first + rank < n:
        column = first + rank
        at, largest = -1, 0.0
        for j in range(rank, size):
            s = 0.0
            for c in range(column, n):
                s += A[j, c] * A[j, c]
            if s > largest and s > _RANK * _RANK * rows.norm2[j]:
                at, largest = j, s
        if at < 0:
            break
        if at != rank:
            for c in range(first, n):
                A[at, c], A[rank, c] = A[rank, c], A[at, c]
            rows.residual[at], rows.residual[rank] = rows.residual[rank], rows.residual[at]
            rows.norm2[at], rows.norm2[rank] = rows.norm2[rank], rows.norm2[at]
        add_reflection(rows, A[rank], column, largest)
        for j in range(rank + 1, size):
            reflect(rows, A[j], column, column + 1)
        rank += 1
    return rank


@subkernel
def divide_by_triangle(rows: LevelRows, b: np.ndarray, first: int, rank: int) -> None:
    """b ← b L₁⁻¹, for a row b whose entries begin at `first`."""
    for k in range(rank - 1, -1, -1):
        s = b[first + k] / rows.A[k, first + k]
        b[first + k] = s
        for c in range(first, first + k):
            b[c] -= s * rows.A[k, c]


@subkernel
def least_squares(rows: LevelRows, size: int, rank: int, first: int) -> float:
    """Move x̄ to where the level's rows are met best; make its Hessian, if it is not the identity.

    With ỹ = L₁ z + r₁ the residual is (ỹ, X ỹ + e), e = r₂ − X r₁. The Hessian in ỹ is
    I + Xᵀ X = Λ Λᵀ: well conditioned, however the rows are scaled.

    Returns:
        The largest residual that is left.
    """
    A, residual, y, n = rows.A, rows.residual, rows.y, rows.y.size
    H, L = square(rows.H, rank), square(rows.L, rank)
    worst = 0.0
    for c in range(n):
        y[c] = 0.0
    if size > rank:
        for i in range(rank):
            for c in range(i):
                H[i, c] = 0.0
            H[i, i] = 1.0
        for j in range(rank, size):
            divide_by_triangle(rows, A[j], first, rank)
            for k in range(rank):
                residual[j] -= A[j, first + k] * residual[k]
            for i in range(rank):
                x = A[j, first + i]
                y[i] -= x * residual[j]
                for c in range(i + 1):
                    H[i, c] += x * A[j, first + c]
        cholesky(H, L)
        solve_lower(L, y[:rank], np.int64(0))
        solve_lower_transposed(L, y, rank)
        for j in range(rank, size):
            s = residual[j]
            for c in range(rank):
                s += A[j, first + c] * y[c]
            worst = max(worst, abs(s))
    z = rows.product
    for c in range(n):
        z[c] = 0.0
    for k in range(rank):
        worst = max(worst, abs(y[k]))
        s = y[k] - residual[k]
        for j in range(k):
            s -= A[k, first + j] * z[first + j]
        z[first + k] = s / A[k, first + k]
    reflect_back(rows, z, first + rank)
    for i in range(n):
        rows.center[i] += z[i]
    return worst


@subkernel
def reduce_cost(rows: LevelRows, H: np.ndarray, g: np.ndarray, first: int) -> bool:
    """Move x̄ to the least of `½ xᵀ H x + gᵀ x` among what is left; make the Hessian's factor.

    Returns:
        False unless the cost is strictly convex there.
    """
    y, w, n = rows.y, rows.product, rows.y.size
    for i in range(n):
        s = g[i]
        for c in range(n):
            s += H[i, c] * rows.center[c]
        y[i] = -s
    reflect(rows, y, 0, first)
    reduced = rows.H
    for i in range(n):
        for c in range(i + 1):
            reduced[i, c] = H[i, c]
    # One reflection after the other from both sides, in the entries that are left.
    for j in range(first):
        v, factor = rows.V[j], rows.factor[j]
        for i in range(j, n):
            s, t = 0.0, v[i]
            for c in range(j, i):
                s += reduced[i, c] * v[c]
                w[c] += reduced[i, c] * t
            w[i] = s + reduced[i, i] * t
        s = 0.0
        for i in range(j, n):
            w[i] *= factor
            s += w[i] * v[i]
        s *= 0.5 * factor
        for i in range(j, n):
            w[i] -= s * v[i]
        for i in range(j + 1, n):
            a, b = v[i], w[i]
            for c in range(j + 1, i + 1):
                reduced[i, c] -= a * w[c] + b * v[c]
    left = n - first
    packed, L = square(rows.H, left), square(rows.L, left)
    for i in range(left):
        for c in range(i + 1):
            packed[i, c] = reduced[first + i, first + c]
    if not cholesky(packed, L):
        return False
    z = y[first:]
    solve_lower(L, z, np.int64(0))
    solve_lower_transposed(L, z, left)
    for c in range(first):
        y[c] = 0.0
    reflect_back(rows, y, first)
    for i in range(n):
        rows.center[i] += y[i]
    return True


@subkernel
def to_coordinates(
    rows: LevelRows,
    c: np.ndarray,
    first: int,
    rank: int,
    weighted: bool,
    indifferent: float,
) -> None:
    """c ← what a row is in the level's coordinates of equal cost, p.

    x = x̄ + Q z; z[first:stop] = L₁⁻¹ Λ⁻ᵀ p, or Λ⁻ᵀ p on the last level, z[stop:] = indifferent · p.

    Args:
        rows: the level.
        c: (n,) coefficients of x.
        first: first entry that is left to the level.
        rank: rank of the level's rows; −1 on the last level.
        weighted: whether there is a Λ.
        indifferent: scale of the directions in which nothing costs anything.
    """
    n, last = c.size, rank < 0
    stop = n if last else first + rank
    reflect(rows, c, 0, stop if not last else first)
    for i in range(first):
        c[i] = 0.0
    if not last:
        divide_by_triangle(rows, c, first, rank)
    if weighted:
        solve_lower(square(rows.L, stop - first), c[first:stop], np.int64(0))
    for i in range(stop, n):
        c[i] *= indifferent


@subkernel
def from_coordinates(
    rows: LevelRows,
    p: np.ndarray,
    first: int,
    rank: int,
    weighted: bool,
    indifferent: float,
) -> None:
    """p ← the displacement of x that it means; see `to_coordinates`."""
    n, last = p.size, rank < 0
    stop = n if last else first + rank
    for i in range(first):
        p[i] = 0.0
    if weighted:
        solve_lower_transposed(square(rows.L, stop - first), p[first:stop], stop - first)
    if not last:
        for k in range(rank):
            s = p[first + k]
            for j in range(k):
                s -= rows.A[k, first + j] * p[first + j]
            p[first + k] = s / rows.A[k, first + k]
    for i in range(stop, n):
        p[i] *= indifferent
    reflect_back(rows, p, stop if not last else first)

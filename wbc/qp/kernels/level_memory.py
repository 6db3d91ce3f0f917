"""Memory of a hierarchical solve, and what every step of a level reads from it."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from wbc.jit.compile import subkernel
from wbc.qp.kernels.schema import integers, reals
from wbc.qp.kernels.working_set import Inequality, WorkingSet

_LEAST_LARGEST = 1.0  # what counts as the largest multiplier when all are small


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
        rate: how fast a step crosses each row, of norm one.
        start: x at the beginning of a level.
        column: coordinate that each row of the working set takes, −1 for none.
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
    rate: Annotated[np.ndarray, reals("rows")]
    start: Annotated[np.ndarray, reals("unknowns")]
    column: Annotated[np.ndarray, integers("capacity")]
    iterations: Annotated[np.ndarray, integers(1)]


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
def largest_multiplier(active: WorkingSet, work: LevelWorkspace, size: int) -> float:
    """Return the largest multiplier of rows of norm one, or `_LEAST_LARGEST`."""
    largest = _LEAST_LARGEST
    for k in range(size):
        largest = max(largest, abs(active.multiplier[k] / work.scale[active.row[k]]))
    return largest

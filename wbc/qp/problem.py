"""The quadratic program and its solution, in the form that every solver uses."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from wbc.qp.levels import Levels
from wbc.qp.rows import RowBlock


@dataclass(slots=True)
class Problem:
    """`min ½ xᵀ H x + gᵀ x` subject to `lb ≤ [x[:bounded]; C x] ≤ ub`.

    The first `bounded` entries of `lb` and `ub` are simple bounds on the first
    variables, the others belong to the rows of C. An equality has `lb == ub`.
    Infinite entries mean no bound.

    Attributes:
        H: (n, n) symmetric positive definite.
        g: (n,).
        C: (m, n).
        lb: (bounded + m,).
        ub: (bounded + m,).
        bounded: number of simple bounds.
        equality: (bounded + m,) True where the row is an equality.
        blocks: names of the rows of `lb` and `ub`.
        finite: no entry is NaN, nor infinite but for bounds.
        levels: strict priorities, see `Levels`; None when there is one cost only.
    """

    H: np.ndarray
    g: np.ndarray
    C: np.ndarray
    lb: np.ndarray
    ub: np.ndarray
    bounded: int
    equality: np.ndarray
    blocks: tuple[RowBlock, ...]
    finite: bool = True
    levels: Levels | None = None

    def values(self, x: np.ndarray) -> np.ndarray:
        """Return what the bounds are compared with at x, (bounded + m,)."""
        return np.concatenate((x[: self.bounded], self.C @ x))

    def exact_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return lb and ub, infinite for the rows that a level may violate."""
        if self.levels is None:
            return self.lb, self.ub
        soft = self.levels.level > 0
        return np.where(soft, -np.inf, self.lb), np.where(soft, np.inf, self.ub)

    def violation(self, x: np.ndarray) -> np.ndarray:
        """Return by how much each row is violated at x, (bounded + m,), 0 where it is not."""
        y = self.values(x)
        return np.asarray(np.maximum(np.maximum(self.lb - y, y - self.ub), 0.0))


class Outcome(Enum):
    """The outcome of a solve."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    FAILED = "failed"


@dataclass(slots=True)
class Solution:
    """The result of a solve; `x` is meaningful only when solved.

    Attributes:
        x: (n,).
        outcome: solved, infeasible or failed.
        iterations: as the solver counts them; 0 when it does not report them.
        detail: the solver's own message on a failure.
    """

    x: np.ndarray
    outcome: Outcome
    iterations: int = 0
    detail: str = ""

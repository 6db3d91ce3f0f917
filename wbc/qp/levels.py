"""The levels of a hierarchy of quadratic programs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(slots=True)
class Levels:
    """What a `Problem` with strict priorities has beside its cost and constraints.

    Level k of 1 … p minimises `½ |G_k x̂|² + ½ Σ ωᵢ wᵢ²`, x̂ = (x, 1), with w the violation of the
    rows of that level, over the optima of the levels before it, all of which hold the rows of
    level 0. The problem's H and g are the cost of level p, which makes the optimum unique.

    Attributes:
        G: (q, n + 1) or larger: residual rows of the levels 1 … p − 1, one level after the other.
        starts: (p,) row of G where each of these levels begins, and where the last of them ends.
        level: (bounded + m,) of each row of `lb` and `ub`: 0 holds exactly.
        weight: (bounded + m,) ω, of the rows of a level above 0.
        priorities: (p,) the priority that stands for each level.
    """

    G: np.ndarray
    starts: np.ndarray
    level: np.ndarray
    weight: np.ndarray
    priorities: tuple[int, ...]

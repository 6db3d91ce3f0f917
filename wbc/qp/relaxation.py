"""Rows that give way where all rows cannot hold: a level of their own above all others."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from wbc.qp.levels import Levels
from wbc.qp.problem import Problem

_NEGLIGIBLE = 1e-9  # violation of a row
_MAX_NAMES = 3


def relaxed_problem(problem: Problem, names: Collection[str]) -> Problem:
    """Return a problem in which the exact rows of some limits are violated as little as possible.

    They become the first of its levels: it minimises `½ Σ w²` over their violations w, and only
    then what the problem minimises. Where they can hold, its optimum is that of the problem.

    Args:
        problem: the problem.
        names: names of the limits.
    """
    size, n, levels = problem.lb.size, problem.g.size, problem.levels
    level = np.zeros(size, dtype=np.int64) if levels is None else levels.level
    yielding = _rows_of(problem, names) & (level == 0)
    if levels is None:
        levels = Levels(
            np.zeros((0, n + 1)), np.zeros(1, dtype=np.int64), level, np.ones(size), (1,)
        )
    level = np.where(level > 0, level + 1, yielding.astype(np.int64))
    starts = np.concatenate(([0], levels.starts))
    weight = np.where(yielding, 1.0, levels.weight)
    above = Levels(levels.G, starts, level, weight, (0, *levels.priorities))
    return replace(problem, levels=above)


def relaxation_text(problem: Problem, x: np.ndarray, names: Collection[str]) -> str:
    """Return which rows of some limits give way at x, and by how much; empty when none do."""
    violation = np.where(_rows_of(problem, names), problem.violation(x), 0.0)
    worst = [
        int(row) for row in np.argsort(-violation)[:_MAX_NAMES] if violation[row] > _NEGLIGIBLE
    ]
    texts = []
    for row in worst:
        block = next(block for block in problem.blocks if row < block.stop)
        texts.append(f"{block.label(row)} by {violation[row]:.3g} {block.unit_of(row)}")
    return f"gives way: {', '.join(texts)}" if texts else ""


def _rows_of(problem: Problem, names: Collection[str]) -> np.ndarray:
    rows = np.zeros(problem.lb.size, dtype=bool)
    for block in problem.blocks:
        if block.name in names:
            rows[block.start : block.stop] = True
    return rows

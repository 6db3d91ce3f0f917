"""Why a QP has no solution: the rows in conflict, named."""

from __future__ import annotations

import numpy as np

from wbc.qp.problem import Problem
from wbc.rows import RowBlock

_MAX_NEWTON = 60
_SHOWN = 6


def least_violation(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """The point that violates the rows least, and its scaled violations.

    Minimises `½ Σ (max(0, l − Cx) + max(0, Cx − u))²` over rows scaled to unit norm, by
    a semismooth Newton method (Mangasarian, A finite Newton method for classification,
    Optimization Methods and Software 2002). At the optimum the violations s satisfy
    `Cᵀ s = 0`: when not zero they are a Farkas certificate, and the rows with s ≠ 0 are
    exactly rows that cannot hold together.

    Returns:
        x (n,) and s (bounded + m,), s > 0 where the upper bound is exceeded and
        s < 0 where the lower one is.
    """
    n, b = problem.g.size, problem.bounded
    A = np.vstack((np.eye(b, n), problem.C))
    norm = np.maximum(np.linalg.norm(A, axis=1), 1e-12)
    A = A / norm[:, None]
    lb, ub = problem.lb / norm, problem.ub / norm
    x = np.zeros(n)
    damping = 1e-10

    def slack(at: np.ndarray) -> np.ndarray:
        y = A @ at
        return np.maximum(y - ub, 0.0) - np.maximum(lb - y, 0.0)

    s = slack(x)
    for _ in range(_MAX_NEWTON):
        gradient = A.T @ s
        if np.linalg.norm(gradient) < 1e-10 * (1.0 + np.linalg.norm(s)):
            break
        active = A[s != 0.0]
        step = -np.linalg.solve(active.T @ active + damping * np.eye(n), gradient)
        length, value = 1.0, s @ s
        while length > 1e-6:
            trial = slack(x + length * step)
            if trial @ trial <= value + 1e-4 * length * 2.0 * (gradient @ step):
                break
            length *= 0.5
        x = x + length * step
        s = slack(x)
    return x, s * norm


def explain(problem: Problem) -> str:
    """One line that names the rows in conflict, the worst first.

    E.g. "cannot hold together: torque limit [leg_left_4_joint] by 12 N·m, left_sole normal
    force [fz] by 40 N". Empty when the rows can hold together.
    """
    if not np.isfinite(problem.C).all() or not np.isfinite(problem.H).all():
        return "the problem has entries that are not finite"
    _, s = least_violation(problem)
    size = np.abs(s)
    worst = float(size.max(initial=0.0))
    if worst < 1e-6:
        return ""
    rows = [int(r) for r in np.argsort(-size) if size[r] > 1e-3 * worst][:_SHOWN]
    texts = []
    for row in rows:
        block = _block_of(problem.blocks, row)
        side = "" if problem.equality[row] else ("above its maximum " if s[row] > 0 else "below its minimum ")
        texts.append(f"{block.label(row)} {side}by {size[row]:.3g} {block.unit}")
    more = int((size > 1e-3 * worst).sum()) - len(rows)
    tail = f" (and {more} rows more)" if more > 0 else ""
    return "cannot hold together: " + "; ".join(texts) + tail


def _block_of(blocks: tuple[RowBlock, ...], row: int) -> RowBlock:
    return next(block for block in blocks if block.start <= row < block.stop)

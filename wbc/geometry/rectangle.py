"""The largest rectangle inside a convex polygon."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

_GRID = 80  # positions of either end that each refinement compares


def inscribed_rectangle(polygon: Sequence[complex]) -> tuple[float, float, float, float]:
    """Return the largest axis-aligned rectangle in a convex polygon: (x0, x1, y0, y1), m.

    Over an interval [x0, x1] a convex polygon's lower edge is highest, and its
    upper edge lowest, at one of the two ends: so the rectangle over it is known
    in closed form, and the two ends are searched on a grid that is then refined.
    A polygon without area gives its bounding interval of zero width.
    """
    hull = np.array([[p.real, p.imag] for p in polygon])
    low, high = hull.min(axis=0), hull.max(axis=0)
    if len(hull) < 3:
        middle = 0.5 * (low + high)
        return (middle[0], middle[0], middle[1], middle[1])
    edges = _edges(hull)
    starts = np.linspace(low[0], high[0], _GRID)
    ends, best = starts, (low[0], low[0], low[1], low[1])
    for _ in range(4):
        bottom0, top0 = _section(edges, starts)
        bottom1, top1 = _section(edges, ends)
        bottom = np.maximum(bottom0[:, None], bottom1[None, :])
        top = np.minimum(top0[:, None], top1[None, :])
        width = ends[None, :] - starts[:, None]
        area = np.where((width > 0.0) & (top > bottom), width * (top - bottom), 0.0)
        i, j = np.unravel_index(int(np.argmax(area)), area.shape)
        best = (starts[i], ends[j], bottom[i, j], top[i, j])
        step0, step1 = starts[1] - starts[0], ends[1] - ends[0]
        starts = np.clip(np.linspace(best[0] - step0, best[0] + step0, _GRID), low[0], high[0])
        ends = np.clip(np.linspace(best[1] - step1, best[1] + step1, _GRID), low[0], high[0])
    return (float(best[0]), float(best[1]), float(best[2]), float(best[3]))


def _edges(hull: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return hull, np.roll(hull, -1, axis=0)


def _section(edges: tuple[np.ndarray, np.ndarray], x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest y of the polygon at each x."""
    a, b = edges
    span = b[:, 0] - a[:, 0]
    steep = np.abs(span) < 1e-12
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (x[:, None] - a[None, :, 0]) / np.where(steep, 1.0, span)[None, :]
    inside = (t >= -1e-9) & (t <= 1.0 + 1e-9) & ~steep[None, :]
    y = a[None, :, 1] + t * (b[:, 1] - a[:, 1])[None, :]
    # A vertical edge matters only through its end points, which its neighbours share.
    return (
        np.where(inside, y, np.inf).min(axis=1),
        np.where(inside, y, -np.inf).max(axis=1),
    )

"""Convex polygons in the plane: hulls, support polygons, the nearest point of a polygon.

Points are complex numbers x + iy, m; see `wbc.geometry.planar`. Polygons are lists of corners,
counter-clockwise.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from wbc.geometry.planar import Placement, planar_rotation


def sole_corners(sole: Placement, half_length: float, half_width: float) -> list[complex]:
    """Return the corners of a sole's rectangle on the ground, counter-clockwise, m."""
    along, across = (
        half_length * planar_rotation(sole.yaw),
        1j * half_width * planar_rotation(sole.yaw),
    )
    front, rear = sole.point + along, sole.point - along
    return [front + across, rear + across, rear - across, front - across]


def convex_hull(points: Iterable[complex]) -> list[complex]:
    """Return the corners of the convex hull, counter-clockwise.

    Andrew's monotone chain (Andrew, Another efficient algorithm for convex hulls in two
    dimensions, Information Processing Letters 1979). Points on one line give fewer than three
    corners.
    """
    ordered = sorted(points, key=lambda p: (p.real, p.imag))
    if len(ordered) < 3:
        return ordered

    def half(run: Sequence[complex]) -> list[complex]:
        chain: list[complex] = []
        for p in run:
            while len(chain) > 1 and _cross(chain[-1] - chain[-2], p - chain[-2]) <= 0.0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(ordered) + half(ordered[::-1])


def polygon_area(polygon: Sequence[complex]) -> float:
    """Return the area of a polygon, m²; 0 for fewer than three corners."""
    sides = zip(polygon, [*polygon[1:], *polygon[:1]], strict=True)
    return 0.5 * abs(sum(_cross(a, b) for a, b in sides))


def is_near_segment(p: complex, a: complex, b: complex, radius: float) -> bool:
    """Whether p is within `radius` (m) of the straight line from a to b."""
    edge, away = b - a, p - a
    along = (away * edge.conjugate()).real / (abs(edge) ** 2 + 1e-18)
    return abs(away - edge * min(max(along, 0.0), 1.0)) <= radius


def clamp_to_polygon(p: complex, polygon: Sequence[complex], margin: float) -> complex:
    """The point of a convex counter-clockwise polygon, grown by `margin` (m), nearest to p."""
    best, best_distance, outside = p, float("inf"), False
    for a, b in zip(polygon, [*polygon[1:], polygon[0]], strict=True):
        edge = b - a
        if _cross(edge, p - a) < 0.0:
            outside = True
        along = ((p - a) * edge.conjugate()).real / (abs(edge) ** 2 + 1e-18)
        nearest = a + edge * min(max(along, 0.0), 1.0)
        distance = abs(p - nearest)
        if distance < best_distance:
            best, best_distance = nearest, distance
    if not outside or best_distance <= margin:
        return p
    return best + (p - best) * (margin / best_distance)


def _cross(a: complex, b: complex) -> float:
    return a.real * b.imag - a.imag * b.real

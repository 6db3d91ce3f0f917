"""Support polygons on the ground."""

from __future__ import annotations

from collections.abc import Sequence

from wbc.gait.planar import Placement, planar_rotation


def sole_corners(sole: Placement, half_length: float, half_width: float) -> list[complex]:
    """Corners of a sole's rectangle on the ground, counter-clockwise."""
    along, across = (
        half_length * planar_rotation(sole.yaw),
        1j * half_width * planar_rotation(sole.yaw),
    )
    front, rear = sole.point + along, sole.point - along
    return [front + across, rear + across, rear - across, front - across]


def convex_hull(points: Sequence[complex]) -> list[complex]:
    """Counter-clockwise convex hull (Andrew's monotone chain, 1979)."""
    ordered = sorted(points, key=lambda p: (p.real, p.imag))

    def half(run: Sequence[complex]) -> list[complex]:
        chain: list[complex] = []
        for p in run:
            while len(chain) > 1 and _cross(chain[-1] - chain[-2], p - chain[-2]) <= 0.0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(ordered) + half(ordered[::-1])


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

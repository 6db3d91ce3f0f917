"""placo's walk pattern: a centre of mass of piecewise constant jerk whose ZMP stays on the feet.

The quadratic program of placo's walk pattern generator, but from any state of the centre of mass:
the generator itself starts at rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Weight of the end at rest against those of the ZMP at each node, which is 1. As an equality it
#: leaves the solver, which eliminates equalities, without a solution on long plans.
_END_WEIGHT = 1e3
#: A plan whose DCM ends farther from rest than this runs away, m.
_MAX_MISS = 0.05


@dataclass(frozen=True, slots=True)
class ComRequest:
    """What is planned: the ZMP at equally spaced nodes, and the support polygons there.

    Attributes:
        omega: natural frequency ω, 1/s.
        interval: time between two nodes, s.
        position: ground point of the centre of mass now, m.
        velocity: its velocity, m/s.
        acceleration: its acceleration, m/s².
        zmp: wanted ZMP at the nodes from one interval after now on, m; at rest at the last one.
        polygons: support polygon at each of them: its corners counter-clockwise, m.
    """

    omega: float
    interval: float
    position: complex
    velocity: complex
    acceleration: complex
    zmp: tuple[complex, ...]
    polygons: tuple[tuple[complex, ...], ...]


@dataclass(frozen=True, slots=True)
class ComPlan:
    """A planned centre of mass.

    Attributes:
        interval: time between two nodes, s.
        nodes: position (m), velocity (m/s), acceleration (m/s²) and the jerk (m/s³) that follows,
            at each node from now on but the last one.
    """

    interval: float
    nodes: tuple[tuple[complex, complex, complex, complex], ...]

    @property
    def duration(self) -> float:
        """Time that is planned, s."""
        return self.interval * len(self.nodes)

    def at(self, time: float) -> tuple[complex, complex, complex]:
        """Position (m), velocity (m/s) and acceleration (m/s²) at a time (s) within the plan."""
        k = min(int(time / self.interval), len(self.nodes) - 1)
        position, velocity, acceleration, jerk = self.nodes[k]
        t = time - k * self.interval
        return (
            position + t * (velocity + t * (acceleration / 2.0 + t * jerk / 6.0)),
            velocity + t * (acceleration + t * jerk / 2.0),
            acceleration + t * jerk,
        )


def plan_com(request: ComRequest) -> ComPlan | None:
    """Return the centre of mass whose ZMP is nearest to the wanted one and inside the polygons.

    With jerks as variables it minimizes the sum of |p − p*|² over the nodes, p = c − c̈/ω², subject
    to p in the polygon of each node and, nearly, rest at the last one (S. Kajita et al., *Biped
    walking pattern generation by using preview control of zero-moment point*, ICRA 2003, with the
    constraints of P.-B. Wieber, *Trajectory free linear model predictive control*, Humanoids 2006,
    which placo solves). None if nothing satisfies them, or the DCM does not come to rest.
    """
    import placo

    problem = placo.Problem()
    count, omega = len(request.zmp), request.omega
    start = (request.position, request.velocity, request.acceleration)
    com = placo.LIPM(problem, request.interval, count, 0.0, *map(_vector, start))
    nodes = zip(request.zmp, request.polygons, strict=True)
    for node, (wanted, polygon) in enumerate(nodes, 1):
        zmp = com.zmp(node, omega**2)
        corners = placo.vector_Vector2d()
        for corner in reversed(polygon):  # placo wants them clockwise
            corners.append(_vector(corner))
        problem.add_constraint(placo.PolygonConstraint.in_polygon_xy(zmp, corners, 0.0))
        problem.add_constraint(zmp == _vector(wanted)).configure("soft", 1.0)
    for last, goal in (
        (com.pos(count), request.zmp[-1]),
        (com.vel(count), 0j),
        (com.acc(count), 0j),
    ):
        problem.add_constraint(last == _vector(goal)).configure("soft", _END_WEIGHT)
    try:
        problem.solve()
    except RuntimeError:
        return None
    path = com.get_trajectory()
    planned = tuple(
        (
            complex(*path.pos(time)),
            complex(*path.vel(time)),
            complex(*path.acc(time)),
            complex(*path.jerk(time + 0.5 * request.interval)),
        )
        for time in request.interval * np.arange(count)
    )
    plan = ComPlan(request.interval, planned)
    position, velocity, _ = plan.at(plan.duration)
    missed = abs(position + velocity / omega - request.zmp[-1])
    return plan if missed < _MAX_MISS else None


def _vector(point: complex) -> np.ndarray:
    return np.array((point.real, point.imag))

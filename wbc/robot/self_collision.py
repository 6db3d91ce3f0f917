"""Distances between the bodies of a robot, and which pairs of bodies are watched."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
import pinocchio as pin

from wbc.robot.collision_pairs import ExcludedPair, excluded_pairs, known_pairs
from wbc.robot.collision_shapes import CollisionShape, collision_shapes
from wbc.robot.computed_once import computed_once
from wbc.robot.robot_model import RobotModel


@dataclass(frozen=True, eq=False)
class SelfCollision:
    """The shapes of a robot's bodies, and the pairs of them whose distance is watched.

    Attributes:
        robot: the robot.
        shapes: convex shapes, see `collision_shapes`.
        geometry: Pinocchio's model of the shapes and pairs.
        pairs: (p, 2) indices of shapes, in the order of `geometry.collisionPairs`.
        excluded: pairs of bodies that are not watched, and why.
        nominal_distance: (p,) distance of each pair in the nominal posture, m.
    """

    robot: RobotModel
    shapes: tuple[CollisionShape, ...]
    geometry: pin.GeometryModel
    pairs: np.ndarray
    excluded: tuple[ExcludedPair, ...]
    nominal_distance: np.ndarray

    def __repr__(self) -> str:
        return f"SelfCollision('{self.robot.name}': {self.report()})"

    def report(self) -> str:
        """Return in one line what was chosen."""
        reasons = Counter(pair.reason for pair in self.excluded)
        why = ", ".join(f"{count} {reason}" for reason, count in reasons.items()) or "none"
        bodies = {tuple(sorted(map(self._joint, pair))) for pair in self.pairs}
        return (
            f"{len(self.shapes)} shapes, {len(bodies)} pairs of bodies watched "
            f"({len(self.pairs)} of shapes), {len(self.excluded)} not ({why})"
        )

    def pair_name(self, k: int) -> str:
        """Return the names of the two links of a pair."""
        first, second = (self.shapes[i].link for i in self.pairs[k])
        return f"{first} – {second}"

    @cached_property
    def _workspace(self) -> tuple[pin.Data, pin.GeometryData]:
        return self.robot.model.createData(), self.geometry.createData()

    def first_contact(self, q: np.ndarray, margin: float = 0.0) -> str:
        """Return the names of two bodies that are nearer than a margin; empty if none are.

        Pairs that are nearer than that in the nominal posture count where they overlap.

        Args:
            q: (nq,) posture.
            margin: m.
        """
        data, geometry_data = self._workspace
        for k, nominal in enumerate(self.nominal_distance):
            geometry_data.collisionRequests[k].security_margin = min(margin, 0.5 * float(nominal))
        model = self.robot.model
        if not pin.computeCollisions(model, data, self.geometry, geometry_data, q, True):
            return ""
        hits = (k for k, r in enumerate(geometry_data.collisionResults) if r.isCollision())
        return self.pair_name(next(hits))

    def _joint(self, shape: int) -> int:
        return self.shapes[shape].joint_id

    def __deepcopy__(self, memo: dict[int, Any]) -> SelfCollision:
        return self  # immutable, as the robot is

    def __reduce__(self) -> tuple[Any, ...]:
        return SelfCollision.of, (self.robot,)

    @staticmethod
    @computed_once
    def of(robot: RobotModel) -> SelfCollision:
        """Return the shapes and pairs of a robot, computed once per robot.

        All pairs of bodies are watched but `wbc.robot.collision_pairs.excluded_pairs`.
        """
        return _choose(robot)

    def least_distance(self, q: np.ndarray) -> tuple[float, int]:
        """Return the least distance of all pairs in a posture (nq,), m, and the pair's index.

        Negative when two bodies overlap.
        """
        distances = self.distances(q)
        if not distances.size:
            return np.inf, -1
        k = int(np.argmin(distances))
        return float(distances[k]), k

    def distances(self, q: np.ndarray) -> np.ndarray:
        """Return the distances of all pairs in a posture (nq,), m."""
        data, geometry_data = self.robot.model.createData(), self.geometry.createData()
        pin.computeDistances(self.robot.model, data, self.geometry, geometry_data, q)
        return np.array([result.min_distance for result in geometry_data.distanceResults])


def coal_shape(shape: CollisionShape) -> Any:
    """Return coal's geometry of a shape."""
    import coal

    match shape.kind:
        case "box":
            return coal.Box(*(2.0 * np.array(shape.size)))
        case "sphere":
            return coal.Sphere(*shape.size)
        case "cylinder":
            return coal.Cylinder(shape.size[0], 2.0 * shape.size[1])
        case "capsule":
            return coal.Capsule(shape.size[0], 2.0 * shape.size[1])
    from scipy.spatial import ConvexHull

    hull = ConvexHull(shape.vertices)
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    center = shape.vertices.mean(axis=0)
    for vertex in shape.vertices:
        points.append(vertex)
    for a, b, c in hull.simplices:
        u, v, w = shape.vertices[[a, b, c]]
        outward = np.cross(v - u, w - u) @ (u - center) > 0.0
        triangles.append(coal.Triangle(*map(int, (a, b, c) if outward else (a, c, b))))
    return coal.Convex(points, triangles)


def shape_geometry(
    shapes: Sequence[CollisionShape], pairs: Sequence[tuple[int, int]] | np.ndarray
) -> pin.GeometryModel:
    """Return Pinocchio's model of shapes and of pairs (p, 2) of them."""
    geometry = pin.GeometryModel()
    for k, shape in enumerate(shapes):
        item = pin.GeometryObject(
            f"{shape.link}_{k}", shape.joint_id, shape.placement, coal_shape(shape)
        )
        geometry.addGeometryObject(item)
    for i, j in pairs:
        geometry.addCollisionPair(pin.CollisionPair(int(i), int(j)))
    return geometry


def _choose(robot: RobotModel) -> SelfCollision:
    shapes = collision_shapes(robot)
    known = known_pairs(robot, shapes, sorted({shape.joint_id for shape in shapes}))
    candidates = [
        (i, j)
        for i, j in combinations(range(len(shapes)), 2)
        if shapes[i].joint_id != shapes[j].joint_id and _bodies(shapes, (i, j)) not in known
    ]
    geometry = shape_geometry(shapes, candidates)
    data, geometry_data = robot.model.createData(), geometry.createData()

    def overlaps(q: np.ndarray) -> set[tuple[int, int]]:
        pin.computeCollisions(robot.model, data, geometry, geometry_data, q, False)
        hit = [k for k, r in enumerate(geometry_data.collisionResults) if r.isCollision()]
        return {_bodies(shapes, candidates[k]) for k in hit}

    excluded = excluded_pairs(robot, known, overlaps)
    left_out = {
        tuple(sorted(map(robot.model.getJointId, (pair.first, pair.second)))) for pair in excluded
    }
    kept = [pair for pair in candidates if _bodies(shapes, pair) not in left_out]
    geometry.removeAllCollisionPairs()
    for i, j in kept:
        geometry.addCollisionPair(pin.CollisionPair(i, j))
    pairs = np.array(kept, dtype=int).reshape(-1, 2)
    found = SelfCollision(robot, shapes, geometry, pairs, excluded, np.zeros(len(kept)))
    object.__setattr__(found, "nominal_distance", found.distances(robot.q_nominal))
    return found


def _bodies(shapes: Sequence[CollisionShape], pair: tuple[int, int]) -> tuple[int, int]:
    """Return the joint ids of a pair of shapes, the smaller first."""
    a, b = shapes[pair[0]].joint_id, shapes[pair[1]].joint_id
    return (a, b) if a < b else (b, a)

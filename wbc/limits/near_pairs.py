"""Which pairs of shapes are near each other, and by what distance."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from wbc.kinematics import Kinematics
from wbc.robot.collision_shapes import CollisionShape, polyhedron_error, shape_points
from wbc.robot.self_collision import shape_geometry

#: Distance, m; index of the pair; nearest points; unit vector from the first to the second.
NearPair = tuple[float, int, np.ndarray, np.ndarray, np.ndarray]


class NearPairs:
    """Finds the pairs of shapes that are nearer than a distance.

    A compiled kernel leaves out all pairs that a sphere around each shape or a plane between both
    separates; the distance of the others comes from coal.

    Args:
        shapes: shapes fixed to joints; joint 0 is the world.
        pairs: (p, 2) indices of shapes.
        geometry: Pinocchio's model of the shapes and pairs; made when left out.

    Attributes:
        pairs: as given.
        joints: (p, 2) joints that move the shapes of each pair.
        vertices: (n, 3) vertices of all shapes in the axes of their joints, m.
        starts: first vertex of each shape, and one past the last.
    """

    def __init__(
        self,
        shapes: Sequence[CollisionShape],
        pairs: np.ndarray,
        geometry: pin.GeometryModel | None = None,
    ) -> None:
        # Here, because it loads Numba.
        from wbc.limits.kernels.distance import separable_pairs_left_out

        self._select = separable_pairs_left_out
        self._shapes = tuple(shapes)
        self.pairs = np.ascontiguousarray(pairs, dtype=np.int64)
        self._geometry = geometry or shape_geometry(shapes, self.pairs)
        self._geometry_data = self._geometry.createData()
        with warnings.catch_warnings():
            # Pinocchio sets it, by which results would depend on the past.
            warnings.simplefilter("ignore", DeprecationWarning)
            for request in self._geometry_data.distanceRequests:
                request.enable_cached_gjk_guess = False
        self._bodies = np.array([shape.joint_id for shape in shapes], dtype=np.int64)
        self.joints = self._bodies[self.pairs]
        corners = [_in_joint_axes(shape) for shape in shapes]
        self.vertices = np.ascontiguousarray(np.vstack(corners))
        self.starts = np.concatenate(([0], np.cumsum([len(c) for c in corners])))
        self._errors = np.array([polyhedron_error(shape) for shape in shapes])
        self._centers, self._radii = np.zeros((len(corners), 3)), np.zeros(len(corners))
        for k in range(len(corners)):
            self._enclose(k)
        self._found = np.zeros(len(self.pairs), dtype=np.int64)

    def __deepcopy__(self, memo: dict[int, Any]) -> NearPairs:
        return NearPairs(self._shapes, self.pairs, self._geometry.copy())

    def __reduce__(self) -> tuple[Any, ...]:
        return NearPairs, (self._shapes, self.pairs)

    def place(self, k: int, shape: CollisionShape) -> None:
        """Replace a shape by the same one at another place."""
        shapes = list(self._shapes)
        shapes[k] = shape
        self._shapes = tuple(shapes)
        self._geometry.geometryObjects[k].placement = shape.placement
        self.vertices[self.starts[k] : self.starts[k + 1]] = _in_joint_axes(shape)
        self._enclose(k)

    def update(self, kin: Kinematics, distance: float) -> list[NearPair]:
        """Return the pairs nearer than a distance, m."""
        count = self._select(
            kin.joint_placements,
            self._bodies,
            self._centers,
            self._radii,
            self._errors,
            self.pairs,
            self.vertices,
            self.starts,
            distance,
            self._found,
        )
        found: list[NearPair] = []
        if count:
            geometry, data = self._geometry, self._geometry_data
            pin.updateGeometryPlacements(kin.model, kin.data, geometry, data)
            for k in self._found[:count].tolist():
                result = pin.computeDistance(geometry, data, k)
                d = result.min_distance
                if d < distance:
                    points = result.getNearestPoint1(), result.getNearestPoint2()
                    found.append((d, k, *points, result.normal))
        return found

    def _enclose(self, k: int) -> None:
        """Put a sphere around a shape."""
        corners = self.vertices[self.starts[k] : self.starts[k + 1]]
        center = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
        self._centers[k] = center
        largest = np.linalg.norm(corners - center, axis=1).max()
        self._radii[k] = largest + self._errors[k]


def _in_joint_axes(shape: CollisionShape) -> np.ndarray:
    """Return the vertices of a shape in the axes of its joint, (n, 3) m."""
    at = shape.placement
    return np.asarray(shape_points(shape) @ at.rotation.T + at.translation)

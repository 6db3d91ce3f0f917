"""Distances between the bodies of a robot as a limit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.limits.barrier import BarrierLimit, BarrierRows
from wbc.robot import RobotModel
from wbc.robot.collision_shapes import shape_points
from wbc.robot.self_collision import SelfCollision

_DEPTH = 0.02  # m: vertices so much farther than the nearest point are kept apart too
_FIRST_GUESS = np.array([1.0, 0.0, 0.0])
_FIRST_SUPPORT = np.zeros(2, dtype=np.int32)
_SHARE_AT_REST = 0.5  # of the nominal distance, which a margin may take


class SelfCollisionLimit(BarrierLimit):
    """Keeps the bodies of a robot apart: `h = d − margin` for the nearest pairs of bodies.

    d is the distance of two convex shapes (negative when they overlap) between the nearest points
    p₁ and p₂ with the unit vector n from one to the other, `ḋ = nᵀ (J₂ − J₁) v`; the same for
    vertices that are at most 2 cm farther, which keeps flat sides from turning into each other.
    Pairs that are
    nearer in the nominal posture than the margin get half of that distance for a margin. Spheres
    around the shapes tell which pairs need a distance at all.

    Args:
        robot: the robot.
        margin: distance that is kept, m.
        detection: pairs farther apart than that are left aside, m.
        size: largest number of rows, those of the nearest pairs first.
        gain: how fast bodies may approach each other, 1/s; see `BarrierLimit`.
        recovery: see `BarrierLimit`.

    Attributes:
        pairs: shapes and pairs; `pairs.report()` tells what was chosen.

    Raises:
        LimitError: a margin that is negative or not below the detection distance, no pair to
            watch, or see `BarrierLimit`.
    """

    def __init__(
        self,
        robot: RobotModel,
        *,
        margin: float = 0.01,
        detection: float = 0.06,
        size: int = 60,
        gain: float = 20.0,
        recovery: float = 0.1,
        name: str = "self-collision limit",
    ) -> None:
        super().__init__(name, size, gain=gain, recovery=recovery)
        if not 0.0 <= margin < detection:
            raise LimitError(
                f"{name}: margin {margin} m must not be negative and below the detection "
                f"distance {detection} m"
            )
        self.pairs = found = SelfCollision.of(robot)
        if not len(found.pairs):
            raise LimitError(f"{name}: there is no pair to watch ({found.report()})")
        self.margin, self.detection = margin, detection
        self._margins = np.minimum(margin, _SHARE_AT_REST * np.maximum(found.nominal_distance, 0.0))
        self._near = _NearPairs(found)
        self._constrained: list[tuple[float, int]] = []
        self._parents = np.array(list(robot.model.parents), dtype=np.int64)
        self._rows = _PointPairs(size)

    @property
    def distances(self) -> dict[str, float]:
        """Pair name -> distance of those constrained in the last tick, m."""
        nearest: dict[str, float] = {}
        for distance, k in self._constrained:
            name = self.pairs.pair_name(k)
            nearest[name] = min(distance, nearest.get(name, distance))
        return nearest

    @property
    def labels(self) -> tuple[str, ...]:
        """One text per row: the pairs that are constrained now."""
        names = [self.pairs.pair_name(k) for _, k in self._constrained]
        return (*names, *(f"row {k}" for k in range(len(names), self.size)))

    @labels.setter
    def labels(self, labels: tuple[str, ...]) -> None:
        """Do nothing: the names of the pairs are the labels."""

    def write_barrier(self, kin: Kinematics, barrier: BarrierRows) -> None:
        """See `BarrierLimit.write_barrier`."""
        # Here, because it loads Numba.
        from wbc.limits.kernels.distance import add_support_points, distance_rates

        near = self._near.update(kin, self.detection)
        near.sort(key=lambda pair: pair[0] - self._margins[pair[1]])
        del near[self.size :]
        rows, found = self._rows, self._near
        for i, (distance, k, first, second, normal) in enumerate(near):
            rows.distances[i], rows.normals[i] = distance, normal
            rows.points[i, 0], rows.points[i, 1] = first, second
            rows.joints[i], rows.shapes[i] = found.joints[k], self.pairs.pairs[k]
        count = add_support_points(
            kin.joint_placements,
            rows.shapes,
            rows.joints,
            rows.points,
            rows.normals,
            rows.distances,
            found.vertices,
            found.starts,
            len(near),
            _DEPTH,
            rows.owners,
        )
        pairs = np.array([k for _, k, *_ in near], dtype=int)[rows.owners[:count]]
        self._constrained = [(d, int(k)) for d, k in zip(rows.distances, pairs, strict=False)]
        barrier.h[:count] = rows.distances[:count] - self._margins[pairs]
        distance_rates(
            kin.data.J.T,
            self._parents,
            rows.joints[:count],
            rows.points[:count],
            rows.normals[:count],
            kin.state.v,
            barrier.J,
            barrier.bias,
        )


class _PointPairs:
    """The pairs of points that are kept apart, in arrays for the kernels.

    Args:
        size: largest number of rows.
    """

    def __init__(self, size: int) -> None:
        self.shapes, self.joints = np.zeros((2, size, 2), dtype=np.int64)
        self.points, self.normals = np.zeros((size, 2, 3)), np.zeros((size, 3))
        self.distances, self.owners = np.zeros(size), np.zeros(size, dtype=np.int64)


#: Distance, m; index of the pair; nearest points; unit vector from the first to the second.
_NearPair = tuple[float, int, np.ndarray, np.ndarray, np.ndarray]


class _NearPairs:
    """Finds the pairs nearer than a distance.

    Attributes:
        joints: (p, 2) joints that move the shapes of each pair.
        vertices: vertices of all shapes in the axes of their joints, m.
        starts: first vertex of each shape, and one past the last.
    """

    def __init__(self, pairs: SelfCollision) -> None:
        self._pairs = pairs
        self._geometry_data = pairs.geometry.createData()
        shapes = pairs.shapes
        self._bodies = np.array([shape.joint_id for shape in shapes])
        self.joints = self._bodies[pairs.pairs]
        centers, radii = zip(*map(_sphere, pairs.geometry.geometryObjects), strict=True)
        self._centers, self._radii = np.array(centers), np.array(radii)
        self._first, self._second = pairs.pairs.T
        corners = [
            shape_points(shape) @ shape.placement.rotation.T + shape.placement.translation
            for shape in shapes
        ]
        self.vertices = np.ascontiguousarray(np.vstack(corners))
        self.starts = np.concatenate(([0], np.cumsum([len(c) for c in corners])))
        self._reach = self._radii[self._first] + self._radii[self._second]

    def __deepcopy__(self, memo: dict[int, Any]) -> _NearPairs:
        return _NearPairs(self._pairs)

    def __reduce__(self) -> tuple[Any, ...]:
        return _NearPairs, (self._pairs,)

    def update(self, kin: Kinematics, distance: float) -> list[_NearPair]:
        """Return the pairs nearer than a distance."""
        placements = kin.joint_placements[self._bodies]
        rotations = placements[:, :9].reshape(-1, 3, 3)  # transposed: columns come first
        centers = placements[:, 9:] + np.einsum("kji,kj->ki", rotations, self._centers)
        apart = centers[self._second] - centers[self._first]
        squares = np.einsum("ki,ki->k", apart, apart)
        near = np.flatnonzero(squares < (self._reach + distance) ** 2)
        geometry, data = self._pairs.geometry, self._geometry_data
        found: list[_NearPair] = []
        if near.size:
            pin.updateGeometryPlacements(kin.model, kin.data, geometry, data)
            for k in near.tolist():
                request = data.distanceRequests[k]
                # What the last call left would make the result depend on the past.
                request.cached_gjk_guess = _FIRST_GUESS
                request.cached_support_func_guess = _FIRST_SUPPORT
                result = pin.computeDistance(geometry, data, k)
                d = result.min_distance
                if d < distance:
                    points = result.getNearestPoint1(), result.getNearestPoint2()
                    found.append((d, k, *points, result.normal))
        return found


def _sphere(item: Any) -> tuple[np.ndarray, float]:
    """Return centre, in the axes of the joint, and radius of a sphere around a shape, m."""
    item.geometry.computeLocalAABB()
    center = item.placement.act(np.array(item.geometry.aabb_center))
    return center, float(item.geometry.aabb_radius)

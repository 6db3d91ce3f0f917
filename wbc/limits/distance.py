"""Distances of the robot's shapes as a limit: from each other, or from obstacles."""

from __future__ import annotations

import numpy as np

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.limits.barrier import BarrierLimit, BarrierRows
from wbc.limits.near_pairs import NearPairs
from wbc.robot import RobotModel

_DEPTH = 0.02  # m: vertices so much farther than the nearest point are kept apart too


class DistanceLimit(BarrierLimit):
    """Keeps pairs of convex shapes apart: `h = d − margin` for the nearest pairs.

    d is the distance of two convex shapes (negative when they overlap) between the nearest points
    p₁ and p₂ with the unit vector n from one to the other, `ḋ = nᵀ (J₂ − J₁) v`; the same for
    vertices that are at most 2 cm farther, which keeps flat sides from turning into each other.

    Args:
        name: unique within a controller.
        robot: the robot.
        near: finds the near pairs.
        pair_names: one text per pair.
        margins: (p,) distance that is kept by each pair, m.
        detection: pairs farther apart than that are left aside, m.
        size: largest number of rows, those of the nearest pairs first.
        gain, recovery, priority, weight: see `BarrierLimit`.

    Raises:
        LimitError: a margin that is negative or not below the detection distance, or see
            `BarrierLimit`.
    """

    def __init__(
        self,
        name: str,
        robot: RobotModel,
        near: NearPairs,
        pair_names: list[str],
        margins: np.ndarray,
        detection: float,
        size: int,
        gain: float,
        recovery: float,
        priority: int,
        weight: float,
    ) -> None:
        super().__init__(name, size, gain=gain, recovery=recovery, priority=priority, weight=weight)
        largest = float(margins.max())
        if not (margins >= 0.0).all() or not largest < detection:
            raise LimitError(
                f"{name}: margin {largest} m must not be negative and below the detection "
                f"distance {detection} m"
            )
        self.detection = detection
        self._near, self._pair_names, self._margins = near, pair_names, margins
        self._constrained: list[tuple[float, int]] = []
        self._parents = np.array(list(robot.model.parents), dtype=np.int64)
        self._rows = _PointPairs(size)

    @property
    def distances(self) -> dict[str, float]:
        """Pair name -> distance of those constrained in the last tick, m."""
        nearest: dict[str, float] = {}
        for distance, k in self._constrained:
            name = self._pair_names[k]
            nearest[name] = min(distance, nearest.get(name, distance))
        return nearest

    @property
    def labels(self) -> tuple[str, ...]:
        """One text per row: the pairs that are constrained now."""
        names = [self._pair_names[k] for _, k in self._constrained]
        return (*names, *(f"row {k}" for k in range(len(names), self.size)))

    @labels.setter
    def labels(self, labels: tuple[str, ...]) -> None:
        """Do nothing: the names of the pairs are the labels."""

    def write_barrier(self, kin: Kinematics, barrier: BarrierRows) -> None:
        """See `BarrierLimit.write_barrier`."""
        # Here, because it loads Numba.
        from wbc.limits.kernels.distance import add_support_points, distance_rates

        near = self._near.update(kin, self.detection)
        if not near:
            self._constrained = []
            return
        near.sort(key=lambda pair: pair[0] - self._margins[pair[1]])
        del near[self.size :]
        rows, found = self._rows, self._near
        distances, indices, firsts, seconds, normals = zip(*near, strict=True)
        n, which = len(near), list(indices)
        rows.distances[:n], rows.normals[:n] = distances, normals
        rows.points[:n, 0], rows.points[:n, 1] = firsts, seconds
        rows.joints[:n], rows.shapes[:n] = found.joints[which], found.pairs[which]
        count = add_support_points(
            kin.joint_placements,
            rows.shapes,
            rows.joints,
            rows.points,
            rows.normals,
            rows.distances,
            found.vertices,
            found.starts,
            n,
            _DEPTH,
            rows.owners,
        )
        pairs = np.array(which)[rows.owners[:count]]
        distance = rows.distances[:count]
        self._constrained = list(zip(distance.tolist(), pairs.tolist(), strict=True))
        barrier.h[:count] = distance - self._margins[pairs]
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

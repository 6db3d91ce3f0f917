"""The centre of mass above the support polygon."""

from __future__ import annotations

import numpy as np

from wbc.errors import LimitError
from wbc.geometry.polygon import convex_hull
from wbc.kinematics import Kinematics
from wbc.limits.barrier import BarrierLimit, BarrierRows


class ComPolygonLimit(BarrierLimit):
    """Keeps the centre of mass c above a convex polygon of the ground.

    One function per side with its inner unit normal n and a corner p, `h = nᵀ (c − p) − margin`.
    With a priority of 1 or more it is a task: the centre of mass is within the polygon as far as
    the tasks of higher levels let it.

    Args:
        points: (k, 2) or (k, 3) points on the ground, world, m, in any order: the corners of the
            contacts. Their convex hull is the polygon; see `set_points`.
        margin: distance kept from the sides, m.
        size: largest number of sides.
        gain, recovery, priority, weight: see `BarrierLimit`.

    Attributes:
        margin: m.

    Raises:
        LimitError: see `set_points` and `BarrierLimit`.
    """

    def __init__(
        self,
        points: np.ndarray,
        *,
        margin: float = 0.0,
        size: int = 16,
        gain: float = 20.0,
        recovery: float = 0.1,
        priority: int = 0,
        weight: float = 1.0,
        name: str = "CoM in support polygon",
    ) -> None:
        super().__init__(
            name,
            size,
            gain=gain,
            recovery=recovery,
            labels=[f"side {k}" for k in range(size)],
            priority=priority,
            weight=weight,
        )
        self.margin = margin
        self.set_points(points)

    @property
    def polygon(self) -> np.ndarray:
        """(k, 2) corners, counter-clockwise, m."""
        return self._corners.copy()

    def set_points(self, points: np.ndarray) -> None:
        """Change the polygon.

        Args:
            points: see the constructor.

        Raises:
            LimitError: a wrong shape, points that span no area, or too many sides.
        """
        points = np.asarray(points, dtype=float)
        if points.ndim != 2 or points.shape[1] not in (2, 3) or not np.isfinite(points).all():
            raise LimitError(
                f"limit '{self.name}': points of shape {points.shape} must be (k, 2) or (k, 3) "
                "finite numbers"
            )
        hull = convex_hull(complex(x, y) for x, y in points[:, :2].tolist())
        if not 3 <= len(hull) <= self.size:
            raise LimitError(
                f"limit '{self.name}': the polygon of {len(points)} points has {len(hull)} "
                f"corners; it must have 3 to {self.size}, see `size`"
            )
        self._corners = corners = np.array([[p.real, p.imag] for p in hull])
        sides = np.roll(corners, -1, axis=0) - corners
        self._normals = np.column_stack((-sides[:, 1], sides[:, 0]))
        self._normals /= np.linalg.norm(sides, axis=1, keepdims=True)
        self._offsets = (self._normals * corners).sum(axis=1)

    def write_barrier(self, kin: Kinematics, barrier: BarrierRows) -> None:
        """See `BarrierLimit.write_barrier`."""
        n = self._normals
        sides = slice(0, len(n))
        barrier.h[sides] = n @ kin.p_com[:2] - self._offsets - self.margin
        barrier.J[sides] = n @ kin.J_com[:2]
        barrier.bias[sides] = n @ kin.bias_com[:2]

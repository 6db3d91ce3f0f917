"""Regions of space that the origin of a frame stays in, or out of."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.limits.barrier import BarrierLimit, BarrierRows
from wbc.robot import RobotModel

_AXES = ("x", "y", "z")


class FrameBoxLimit(BarrierLimit):
    """Keeps the origin of a frame in a box, `lower ≤ p ≤ upper`.

    Six functions, h = p − lower and h = upper − p.

    Args:
        frame: name of the frame.
        lower: (3,) m, world; −∞ for none.
        upper: (3,) m; ∞ for none.
        gain, recovery, priority, weight: see `BarrierLimit`.

    Attributes:
        frame: as given.
        lower, upper: (3,) m; may be set anew at any time.

    Raises:
        LimitError: bounds of a wrong shape or without room between them, or see `BarrierLimit`.
    """

    def __init__(
        self,
        frame: str,
        lower: np.ndarray | tuple[float, float, float],
        upper: np.ndarray | tuple[float, float, float],
        *,
        gain: float = 20.0,
        recovery: float = 0.1,
        priority: int = 0,
        weight: float = 1.0,
        name: str = "",
    ) -> None:
        super().__init__(
            name or f"{frame} box",
            6,
            gain=gain,
            recovery=recovery,
            labels=[f"{axis} {side}" for side in ("minimum", "maximum") for axis in _AXES],
            priority=priority,
            weight=weight,
        )
        self.frame = frame
        self.lower, self.upper = (np.array(x, dtype=float) for x in (lower, upper))
        for what, bound in (("lower", self.lower), ("upper", self.upper)):
            if bound.shape != (3,):
                raise LimitError(
                    f"limit '{self.name}': {what} has shape {bound.shape}, expected (3,)"
                )
        if not (self.lower < self.upper).all():
            raise LimitError(
                f"limit '{self.name}': lower {self.lower} m must be below upper {self.upper} m"
            )

    def bind(self, robot: RobotModel) -> None:
        """See `Limit.bind`."""
        self._frame_id = robot.frame_id(self.frame)

    def write_barrier(self, kin: Kinematics, barrier: BarrierRows) -> None:
        """See `BarrierLimit.write_barrier`."""
        at = kin.motion(self._frame_id)
        barrier.h[:3], barrier.h[3:] = at.position - self.lower, self.upper - at.position
        barrier.J[:3], barrier.J[3:] = at.jacobian[:3], -at.jacobian[:3]
        barrier.bias[:3], barrier.bias[3:] = at.bias[:3], -at.bias[:3]


class KeepOutLimit(BarrierLimit):
    """Keeps the origin of a frame out of a region: a box with rounded edges.

    h is the distance of the origin to the region's surface, negative inside. With p the origin in
    the axes of the region, b the half sizes, ρ the radius and r = p − clip(p, −b, b),

        h = |r| − ρ,   ḧ = nᵀ p̈ + (|ṙ|² − (n·ṙ)²)/|r|,   n = r/|r|;

    within the box itself h is −ρ minus the distance to its nearest face. Half sizes of zero
    give a sphere, one that is not zero a capsule, a radius of zero a box.

    Args:
        frame: name of the frame.
        placement: `T_world_region`, its centre and axes.
        half_size: (3,) half sizes of the box, m.
        radius: of its edges, added to the half sizes, m.
        gain, recovery, priority, weight: see `BarrierLimit`.

    Attributes:
        frame, half_size, radius: as given.
        placement: `T_world_region`; may be set anew at any time.

    Raises:
        LimitError: a negative size, no size at all, or see `BarrierLimit`.
    """

    def __init__(
        self,
        frame: str,
        placement: pin.SE3,
        *,
        half_size: np.ndarray | tuple[float, float, float] = (0.0, 0.0, 0.0),
        radius: float = 0.0,
        gain: float = 20.0,
        recovery: float = 0.1,
        priority: int = 0,
        weight: float = 1.0,
        name: str = "",
    ) -> None:
        super().__init__(
            name or f"{frame} keep-out region",
            1,
            gain=gain,
            recovery=recovery,
            labels=("distance",),
            priority=priority,
            weight=weight,
        )
        self.frame, self.placement = frame, placement
        self.half_size, self.radius = np.array(half_size, dtype=float), float(radius)
        sizes = np.array([*np.ravel(self.half_size), self.radius])
        if self.half_size.shape != (3,) or not (sizes >= 0.0).all() or not sizes.any():
            raise LimitError(
                f"limit '{self.name}': half sizes {self.half_size} m (3,) and radius {radius} m "
                "must not be negative, nor all of them zero"
            )
        if not isinstance(placement, pin.SE3):
            raise LimitError(
                f"limit '{self.name}': placement is a {type(placement).__name__}, not a pin.SE3"
            )

    def bind(self, robot: RobotModel) -> None:
        """See `Limit.bind`."""
        self._frame_id = robot.frame_id(self.frame)

    def write_barrier(self, kin: Kinematics, barrier: BarrierRows) -> None:
        """See `BarrierLimit.write_barrier`."""
        at, R = kin.motion(self._frame_id), self.placement.rotation
        p = R.T @ (at.position - self.placement.translation)
        r = p - np.clip(p, -self.half_size, self.half_size)
        length = float(np.linalg.norm(r))
        if length > 0.0:
            n = r / length
            rate = np.where(r != 0.0, R.T @ at.velocity[:3], 0.0)
            barrier.h[0] = length - self.radius
            barrier.bias[0] = (rate @ rate - (n @ rate) ** 2) / length
        else:
            depth = self.half_size - np.abs(p)
            face = int(np.argmin(depth))
            n = np.zeros(3)
            n[face] = 1.0 if p[face] >= 0.0 else -1.0
            barrier.h[0] = -depth[face] - self.radius
        normal = R @ n
        barrier.J[0] = normal @ at.jacobian[:3]
        barrier.bias[0] += normal @ at.bias[:3]

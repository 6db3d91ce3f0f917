"""A foot that is held up while the robot stands on the other one."""

from __future__ import annotations

import numpy as np

from wbc.geometry.planar import Placement, planar_rotation, wrap_angle

_SETTLED = 0.003  # m: a foot without a sensor has landed this far below where it left


class LiftedFoot:
    """Reference of a sole's centre that is raised, held and lowered as somebody else says.

    It has a `SwingFoot`'s attributes, and stays where it is relative to the support foot.

    Args:
        start: where the sole left the ground.
        stance: the support sole.

    Attributes:
        offset: (4,) from `start`: forward, left (m, in the axes the sole had there), up (m),
            turned left (rad).
        offset_velocity: (4,) per s.
        offset_acceleration: (4,) per s².
        expects_contact: whether contact now means that it stands again.
    """

    target_frozen = True  #: no step adjustment

    def __init__(self, start: Placement, stance: Placement) -> None:
        self._relative = start.relative_to(stance)
        self._stance = stance
        self.offset = np.zeros(4)
        self.offset_velocity = np.zeros(4)
        self.offset_acceleration = np.zeros(4)
        self.expects_contact = False

    def follow_support(self, stance: Placement) -> None:
        """Keep the place relative to the support sole, as it is estimated now."""
        self._stance = stance

    @property
    def overdue(self) -> bool:
        """Lowered so far that a foot without a sensor counts as landed."""
        return self.expects_contact and bool(self.offset[2] < -_SETTLED)

    def _start(self) -> Placement:
        return self._stance.compose(self._relative)

    @property
    def target(self) -> Placement:
        """Where it will stand: below where it is."""
        start = self._start()
        x, y, _, yaw = (float(o) for o in self.offset)
        return Placement(start.to_world(complex(x, y)), wrap_angle(start.yaw + yaw), start.height)

    @property
    def position(self) -> tuple[float, float, float]:
        """World position of the sole's centre, m."""
        at = self.target
        return (at.point.real, at.point.imag, at.height + float(self.offset[2]))

    def _turned(self, x: np.ndarray) -> tuple[float, float, float]:
        flat = complex(float(x[0]), float(x[1])) * planar_rotation(self._start().yaw)
        return (flat.real, flat.imag, float(x[2]))

    @property
    def velocity(self) -> tuple[float, float, float]:
        """m/s."""
        return self._turned(self.offset_velocity)

    @property
    def acceleration(self) -> tuple[float, float, float]:
        """m/s²."""
        return self._turned(self.offset_acceleration)

    @property
    def yaw(self) -> float:
        """Heading, rad."""
        return self.target.yaw

    @property
    def yaw_rate(self) -> float:
        """rad/s."""
        return float(self.offset_velocity[3])

    @property
    def yaw_acceleration(self) -> float:
        """rad/s²."""
        return float(self.offset_acceleration[3])

    def path(self, points: int = 12) -> list[tuple[float, float, float]]:
        """Straight down, for display."""
        x, y, z = self.position
        ground = self.target.height
        steps = max(points, 1)
        return [(x, y, z + (ground - z) * k / steps) for k in range(steps + 1)]

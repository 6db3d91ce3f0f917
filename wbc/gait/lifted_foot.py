"""A foot that is held up while the robot stands on the other one."""

from __future__ import annotations

import numpy as np

from wbc.geometry.planar import Placement, planar_rotation, set_rotation_about_z, wrap_angle
from wbc.tasks import TaskReference

_SETTLED = 0.003  # m: a foot without a sensor has landed this far below where it left


class LiftedFoot:
    """Reference of a sole's centre that is raised, held and lowered as somebody else says.

    It has a `SwingFoot`'s attributes, and stays where it is relative to the support foot.

    Args:
        start: placement of the sole when it left the ground.
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
        self._motion = TaskReference(np.eye(4), np.zeros(6), np.zeros(6))

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
        """The placement at which it will stand: below its present one."""
        start = self._start()
        x, y, _, yaw = (float(o) for o in self.offset)
        return Placement(start.to_world(complex(x, y)), wrap_angle(start.yaw + yaw), start.height)

    @property
    def motion(self) -> TaskReference:
        """Pose, velocity and acceleration of the sole's centre now, world axes."""
        motion, at, offset = self._motion, self.target, self.offset
        set_rotation_about_z(motion.rotation, at.yaw)
        motion.position[:] = at.point.real, at.point.imag, at.height + offset[2]
        turn = planar_rotation(self._start().yaw)
        for to, rate in (
            (motion.velocity, self.offset_velocity),
            (motion.acceleration, self.offset_acceleration),
        ):
            x, y, z, yaw = rate.tolist()
            flat = complex(x, y) * turn
            to[:] = flat.real, flat.imag, z, 0.0, 0.0, yaw
        return motion

    @property
    def yaw(self) -> float:
        """Heading, rad."""
        return self.target.yaw

    @property
    def yaw_rate(self) -> float:
        """rad/s."""
        return float(self.offset_velocity[3])

    def path(self, points: int = 12) -> list[tuple[float, float, float]]:
        """Straight down, for display."""
        x, y, z = self.motion.position.tolist()
        ground = self.target.height
        steps = max(points, 1)
        return [(x, y, z + (ground - z) * k / steps) for k in range(steps + 1)]

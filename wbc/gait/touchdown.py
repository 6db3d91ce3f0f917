"""Where the present swing lands: planned, carried along with the support sole, moved by balance."""

from __future__ import annotations

from wbc.gait.footsteps import clamp_footstep
from wbc.gait.parameters import GaitParameters
from wbc.geometry.planar import Placement, planar_rotation, wrap_angle


class Touchdown:
    """Landing place of a swing.

    Attributes:
        planned: where the gait wants it: fixed in the support sole's axes, as measured now.
        adjustment: by how much balance moves it, in the support sole's axes, m.
        is_given: it is from a list of footsteps, not from a velocity.
    """

    def __init__(self) -> None:
        self.planned = Placement(0j, 0.0)
        self.adjustment = 0j
        self.is_given = False
        self._local, self._yaw, self._rise = 0j, 0.0, 0.0

    def plan(self, stance: Placement, target: Placement) -> None:
        """Plan a place, and keep it relative to the support sole."""
        self._local = stance.to_local(target.point)
        self._yaw = wrap_angle(target.yaw - stance.yaw)
        self._rise = target.height - stance.height
        self.follow_stance(stance)

    def follow_stance(self, stance: Placement) -> None:
        """The support sole is measured anew: the planned place goes along."""
        self.planned = Placement(
            stance.to_world(self._local),
            wrap_angle(stance.yaw + self._yaw),
            stance.height + self._rise,
        )

    def adjusted(self, stance: Placement, side: str, gait: GaitParameters) -> Placement:
        """The planned place moved by `adjustment`, within the leg's reach."""
        planned = self.planned
        if self.adjustment == 0j:
            return planned
        point = planned.point + self.adjustment * planar_rotation(stance.yaw)
        moved = Placement(point, planned.yaw, planned.height)
        return clamp_footstep(stance, side, moved, gait)

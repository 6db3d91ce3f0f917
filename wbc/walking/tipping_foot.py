"""The contact of a support foot that tips over an edge of its sole."""

from __future__ import annotations

from wbc.contacts import EdgeContact
from wbc.controller import WholeBodyController
from wbc.geometry.planar import Placement, rotation_about_z
from wbc.robot import Sole
from wbc.tasks import OrientationTask
from wbc.walking.gains import WalkerGains

_EDGES = (1 + 0j, -1 + 0j, 1j, -1j)
_KP = 1000.0  # 1/s²


class TippingFoot:
    """Edge contacts of a sole, and the task that keeps it from tipping farther than it has to.

    A force at the edge does not hold the foot: it weighs little, so that a millimetre between the
    edge and where the ground presses turns it about in some hundredths of a second. The task turns
    it back to the ground stiffly; as far as the ankle does not bend, it tips.

    Args:
        sole: the sole.
        controller: gets the task while the foot tips.
        gains: the walker's.
    """

    def __init__(self, sole: Sole, controller: WholeBodyController, gains: WalkerGains) -> None:
        self._controller = controller
        self._edges = {
            edge: EdgeContact.of_sole(sole, edge, friction=gains.friction) for edge in _EDGES
        }
        for contact in self._edges.values():
            contact.bind(controller.robot)
        self._flatness = OrientationTask(
            sole.name, weight=gains.tipping_weight, kp=_KP, name=f"flatness of {sole.name}"
        )
        self._tips = False

    def contact(self, edge: complex) -> EdgeContact:
        """Return the contact of an edge, see `GaitState.tipping`."""
        return self._edges[edge]

    def update(self, edge: complex, foot: Placement) -> None:
        """Hold the foot as flat as its ankle lets it be while it tips.

        Args:
            edge: the edge over which it tips; 0 for none.
            foot: its placement.
        """
        tips = edge != 0j
        if tips is not self._tips:
            if tips:
                self._controller.add(self._flatness)
            else:
                self._controller.remove(self._flatness)
            self._tips = tips
        if tips:
            self._flatness.target = rotation_about_z(foot.yaw)

"""Where the page shows the handles by which hands are led."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from wbc.robot.upper_body import UpperBody

if TYPE_CHECKING:
    from wbc.robot import Robot


class HandHandles:
    """Finds the handle of each hand: at its target, or without one at the hand.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot, self._data = robot, robot.model.createData()
        self._frames = {arm.side: robot.frame_id(arm.hand) for arm in UpperBody.of(robot).arms}

    def describe(self, tick: Any) -> dict[str, dict[str, Any]]:
        """Return the place, (x, y, z) in world axes, m, of each handle, and whether it leads.

        Args:
            tick: Record of a tick.
        """
        q = np.array(tick["q"])
        if not self._frames or not np.isfinite(q).all():
            return {}
        pin.forwardKinematics(self._robot.model, self._data, q)
        handles: dict[str, dict[str, Any]] = {}
        for side, frame in self._frames.items():
            hand = pin.updateFramePlacement(self._robot.model, self._data, frame).translation
            target = np.array(tick[f"{side}_hand_target"])
            leads = bool(np.isfinite(target).all())
            place = np.round(target if leads else hand, 4).tolist()
            handles[side] = {"at": place, "leads": leads}
        return handles

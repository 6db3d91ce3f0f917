"""What the walker reads off its feet: where the soles are and what they carry."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from wbc.errors import ContactError
from wbc.gait import Feet, Placement
from wbc.gait.planar import point, yaw_of
from wbc.kinematics import Kinematics
from wbc.robot import Robot


def placements(kin: Kinematics) -> Feet:
    """Both soles on the ground, as the kinematics place them."""

    def sole(index: int) -> Placement:
        at = kin.motion(kin.robot.soles[index].frame_id)
        return Placement(point(at.position), yaw_of(at.rotation), float(at.position[2]))

    return Feet(sole(0), sole(1))


def loads(robot: Robot, wrenches: Mapping[str, np.ndarray] | None) -> dict[str, float] | None:
    """Share of the weight on each side; None when nothing is measured.

    Args:
        robot: the robot.
        wrenches: sole name -> (6,) wrench from the ground in sole axes; N, N·m.

    Raises:
        ContactError: a sole is missing, or a wrench has the wrong shape or is not finite.
    """
    if not wrenches:
        return None
    shares: dict[str, float] = {}
    for sole in robot.soles:
        if sole.name not in wrenches:
            raise ContactError(
                f"foot_wrenches has {sorted(wrenches)} but not '{sole.name}'; "
                "give both soles, or None"
            )
        wrench = np.asarray(wrenches[sole.name], dtype=float)
        if wrench.shape != (6,):
            raise ContactError(
                f"foot_wrenches['{sole.name}'] has shape {wrench.shape}, expected (6,): "
                "force then moment in sole axes"
            )
        if not np.isfinite(wrench.sum()):
            raise ContactError(f"foot_wrenches['{sole.name}'] = {wrench} is not finite")
        shares[sole.side] = float(wrench[2]) / robot.weight
    return shares

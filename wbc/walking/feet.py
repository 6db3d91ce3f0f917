"""What the walker reads off its feet: where the soles are and what they carry."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from wbc.errors import ContactError
from wbc.gait import Feet, Placement
from wbc.gait.planar import yaw_of
from wbc.kinematics import Kinematics
from wbc.robot import Robot


def foot_placements(kin: Kinematics) -> Feet:
    """Both soles on the ground, as the kinematics place them."""
    left, right = kin.robot.soles
    return Feet(_placement(kin, left.frame_id), _placement(kin, right.frame_id))


def _placement(kin: Kinematics, frame_id: int) -> Placement:
    at = kin.frame(frame_id)
    x, y, z = at.translation.tolist()
    return Placement(complex(x, y), yaw_of(at.rotation), z)


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
        values = wrench.tolist()
        if not math.isfinite(sum(values)):
            raise ContactError(f"foot_wrenches['{sole.name}'] = {wrench} is not finite")
        shares[sole.side] = values[2] / robot.weight
    return shares

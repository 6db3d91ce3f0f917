"""Where the soles are, and which of them stand."""

from __future__ import annotations

from wbc.estimation import Estimate
from wbc.gait import Feet, Placement
from wbc.geometry.planar import yaw_of
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


def sides_in_contact(robot: Robot, estimate: Estimate) -> frozenset[str] | None:
    """Return the sides whose soles stand; None when the robot has no foot sensors."""
    if estimate.loads is None:
        return None
    return frozenset(sole.side for sole in robot.soles if sole.name in estimate.contacts)

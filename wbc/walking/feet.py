"""What the walker reads off its feet: where the soles are and what they carry."""

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


def loads_by_side(robot: Robot, estimate: Estimate) -> dict[str, float] | None:
    """Share of the weight on each side; None when nothing is measured."""
    loads = estimate.loads
    return None if loads is None else {sole.side: loads[sole.name] for sole in robot.soles}

"""The frames that every humanoid has by REP 120, whatever its URDF calls its links.

`base_link` is the base, `l_sole` and `r_sole` are the soles, `gaze` lies where the head is and
points where it looks, and `base_footprint` is the base's projection on the ground under the feet.
Source: REP 120, "Coordinate Frames for Humanoid Robots".
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from wbc.geometry.planar import rotation_about_z, yaw_of
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody
from wbc.topics.batch import TickBatch

BASE_LINK, BASE_FOOTPRINT = "base_link", "base_footprint"


class FixedFrame(NamedTuple):
    """A frame that is fixed to a link.

    Attributes:
        name: Name of the frame.
        parent: Name of the link's frame.
        placement: Pose in the link's axes.
    """

    name: str
    parent: str
    placement: pin.SE3


def standard_frames(robot: Robot) -> list[FixedFrame]:
    """Return the fixed frames of REP 120 that the robot's URDF does not have.

    A robot without a head that can be turned has no `gaze`.
    """
    same = pin.SE3.Identity()
    frames = [FixedFrame(BASE_LINK, robot.base, same)]
    if not robot.is_quadruped:
        left, right = (sole.name for sole in robot.soles)
        frames += [FixedFrame("l_sole", left, same), FixedFrame("r_sole", right, same)]
    head = UpperBody.of(robot).head
    if head is not None:
        data = robot.model.createData()
        pin.framesForwardKinematics(robot.model, data, robot.standing().q)
        link = data.oMf[robot.frame_id(head.frame)]
        # The nominal posture looks ahead, along the world's x axis.
        frames.append(FixedFrame("gaze", head.frame, pin.SE3(link.rotation.T, np.zeros(3))))
    return [frame for frame in frames if not robot.model.existFrame(frame.name)]


def base_footprints(batch: TickBatch) -> np.ndarray:
    """Return the poses of `base_footprint` in the base, shape (n, 7).

    It lies midway between the soles, at the height of the lower one, is level and heads where the
    base's x axis points.
    """
    soles = np.array([poses[:, :3] for poses in batch.kinematics.soles.values()])
    places = soles.mean(axis=0)
    places[:, 2] = soles[:, :, 2].min(axis=0)
    found = np.empty((len(batch), 7))
    for k, (q, place) in enumerate(zip(batch.records["q"], places, strict=True)):
        base = pin.XYZQUATToSE3(q[:7])
        level = pin.SE3(rotation_about_z(yaw_of(base.rotation)), place)
        found[k] = pin.SE3ToXYZQUATtuple(base.actInv(level))
    return found

"""`tf` and `tf_static`: the transforms of all links.

The tree is that of the URDF, as `robot_state_publisher` publishes it, with `odom` as the parent of
the base, and the soles and those of `wbc.topics.standard_frames` as additional frames.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import prod
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from wbc.messages import Message, message_type
from wbc.robot import Robot
from wbc.runtime.schema import ODOM
from wbc.topics.batch import TickBatch
from wbc.topics.numeric import NumericTopic
from wbc.topics.standard_frames import BASE_FOOTPRINT, base_footprints, standard_frames
from wbc.topics.topic import LatchedTopic


class Link(NamedTuple):
    """A link and its parent in the tree.

    Attributes:
        name: Name of the link's frame.
        parent: Name of the parent's frame.
        moves: Whether a joint is between them.
    """

    name: str
    parent: str
    moves: bool


def links(robot: Robot) -> list[Link]:
    """Return all links except the root, and the soles."""
    model = robot.model
    soles = {sole.name for sole in robot.soles}
    found = []
    for frame in model.frames[1:]:
        parent = _parent(model, frame)
        if parent is not None and (frame.type == pin.BODY or frame.name in soles):
            moves = frame.parentJoint != parent.parentJoint
            found.append(Link(frame.name, parent.name, moves))
    return found


def _parent(model: pin.Model, frame: pin.Frame) -> pin.Frame | None:
    """Return the frame of a frame's parent link; None for the root link."""
    while frame.parentFrame:
        frame = model.frames[frame.parentFrame]
        if frame.type == pin.BODY:
            return frame
    return None


class LinkPoses:
    """Computes the poses of links relative to their parents.

    Args:
        robot: Robot of the links.
        links: Links whose poses are computed.
    """

    def __init__(self, robot: Robot, links: Iterable[Link]) -> None:
        self._model, self._data = robot.model, robot.model.createData()
        # The elements of `liMi` are references, which the forward kinematics updates.
        of_joints, frames = self._data.liMi, robot.model.frames
        self._factors: list[tuple[pin.SE3, ...]] = []
        for link in links:
            parent, frame = frames[robot.frame_id(link.parent)], frames[robot.frame_id(link.name)]
            before, after = parent.placement.inverse(), frame.placement
            constant = [() if x.isIdentity() else (x,) for x in (before, after)]
            joint = (of_joints[frame.parentJoint],) if link.moves else ()
            self._factors.append((*constant[0], *joint, *constant[1]))

    def at(self, q: np.ndarray) -> np.ndarray:
        """Return translation (m) and quaternion (x y z w) of each link in its parent, shape (n, 7).

        Args:
            q: Configuration, shape (nq,).
        """
        pin.forwardKinematics(self._model, self._data, q)
        poses = [
            pin.SE3ToXYZQUATtuple(one[0] if len(one) == 1 else prod(one, start=pin.SE3.Identity()))
            for one in self._factors
        ]
        return np.array(poses).reshape(-1, 7)


def moving_link_transforms(robot: Robot, period: float) -> NumericTopic:
    """Return the topic `/tf`: the base in `odom`, its footprint, and the links that move.

    Args:
        robot: Robot of the ticks.
        period: Period of the messages, s; 0 publishes every tick.
    """
    moving = [link for link in links(robot) if link.moves]
    poses = LinkPoses(robot, moving)

    def values(batch: TickBatch) -> dict[str, np.ndarray]:
        q = batch.records["q"]
        relative = np.array([poses.at(row) for row in q]).reshape(len(q), -1, 7)
        parts = (q[:, None, :7], base_footprints(batch)[:, None], relative)
        return {"transforms[{}].transform": np.concatenate(parts, axis=1)}

    children = [(link.parent, link.name) for link in moving]
    message = _transforms([(ODOM, robot.base), (robot.base, BASE_FOOTPRINT), *children])
    return NumericTopic("/tf", message, values, period)


def fixed_link_transforms(robot: Robot) -> LatchedTopic:
    """Return the topic `/tf_static`: links and frames that are fixed to their parents."""
    fixed = [link for link in links(robot) if not link.moves]
    standard = standard_frames(robot)
    message = _transforms(
        [*((link.parent, link.name) for link in fixed), *((f.parent, f.name) for f in standard)]
    )
    poses = [
        *LinkPoses(robot, fixed).at(robot.q_nominal),
        *(pin.SE3ToXYZQUATtuple(one.placement) for one in standard),
    ]
    for one, pose in zip(message.transforms, poses, strict=True):
        translation, rotation = one.transform.translation, one.transform.rotation
        translation.x, translation.y, translation.z = pose[:3]
        rotation.x, rotation.y, rotation.z, rotation.w = pose[3:]
    return LatchedTopic("/tf_static", message)


def _transforms(frames: Iterable[tuple[str, str]]) -> Message:
    """Return a message with the names of parents and children."""
    message = message_type("tf2_msgs/msg/TFMessage")()
    transform = message_type("geometry_msgs/msg/TransformStamped")
    for parent, child in frames:
        one = transform(child_frame_id=child)
        one.header.frame_id = parent
        message.transforms.append(one)
    return message

"""`tf` and `tf_static`: the transforms of all links.

The tree is that of the URDF, as `robot_state_publisher` publishes it, with `odom` as the parent of
the base, and the soles as additional frames. Each link moves relative to its parent by one joint,
so the transforms of all moving links are computed at once:

    T_parent_link(θ) = A · exp(s θ) · B,   s = (w, v) the joint's axis or direction.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.messages import Template, message_type
from wbc.robot import Robot
from wbc.runtime.schema import ODOM
from wbc.topics.batch import TickBatch
from wbc.topics.latched import LatchedTopic
from wbc.topics.message_topic import MessageTopic, TopicMessage

_TYPE = "tf2_msgs/msg/TFMessage"
_CDR_HEADER = 4  # bytes
_YZX, _ZXY = np.array([1, 2, 0]), np.array([2, 0, 1])


@dataclass(frozen=True)
class Link:
    """A link and its parent in the tree.

    Attributes:
        name: Name of the link's frame.
        parent: Name of the parent's frame.
        before: T_parent_joint at joint position zero.
        after: T_joint_link.
        joint: Index of the joint between them among the actuated ones; None if it is fixed.
        axis: Twist per unit of joint velocity, linear then angular, joint axes, shape (6,).
    """

    name: str
    parent: str
    before: pin.SE3
    after: pin.SE3
    joint: int | None = None
    axis: np.ndarray | None = None


def links(robot: Robot) -> list[Link]:
    """Return all links except the root, and the soles."""
    model = robot.model
    axes = _axes(model)
    found = []
    soles = {sole.name for sole in robot.soles}
    for frame in model.frames[1:]:
        if frame.type != pin.BODY and frame.name not in soles:
            continue
        parent = _parent(model, frame)
        if parent is None:
            continue  # the root link
        joint = frame.parentJoint
        if joint == parent.parentJoint:
            found.append(Link(frame.name, parent.name, parent.placement.inverse(), frame.placement))
        else:
            before = parent.placement.actInv(model.jointPlacements[joint])
            index = model.joints[joint].idx_v - 6
            found.append(Link(frame.name, parent.name, before, frame.placement, index, axes[joint]))
    return found


def _parent(model: pin.Model, frame: pin.Frame) -> pin.Frame | None:
    """Return the frame of a frame's parent link."""
    while frame.parentFrame:
        frame = model.frames[frame.parentFrame]
        if frame.type == pin.BODY:
            return frame
    return None


def _axes(model: pin.Model) -> list[np.ndarray]:
    """Return each joint's twist per unit of its coordinate, from one forward kinematics call."""
    data = model.createData()
    q = pin.neutral(model)
    q[7:] = 1.0
    pin.forwardKinematics(model, data, q)
    return [
        pin.log6(placement.actInv(moved)).vector
        for placement, moved in zip(model.jointPlacements, data.liMi, strict=True)
    ]


class MovingLinks:
    """Computes the transforms of all moving links at once.

    Args:
        links: Moving links.
    """

    def __init__(self, links: list[Link]) -> None:
        self._joints = np.array([link.joint for link in links], dtype=int)
        axes = np.array([link.axis for link in links]).reshape(-1, 6)
        self._slide, self._turn = axes[:, :3], axes[:, 3:]
        self._before = _quaternions([link.before for link in links])
        self._before_at = np.array([link.before.translation for link in links])
        self._before_matrix = np.array([link.before.rotation for link in links])
        self._after = _quaternions([link.after for link in links])
        self._after_at = np.array([link.after.translation for link in links])

    def at(self, joints: np.ndarray) -> np.ndarray:
        """Return translation (m) and quaternion (x y z w) of each link in its parent, shape (n, 7).

        Args:
            joints: Joint positions, rad or m, shape (na,).
        """
        theta = joints[self._joints][:, None]
        half = 0.5 * theta
        middle = np.concatenate((np.sin(half) * self._turn, np.cos(half)), axis=1)
        turned = _product(self._before, middle)
        out = np.empty((len(theta), 7))
        inner = theta * self._slide + _rotate(middle, self._after_at)
        out[:, :3] = self._before_at + np.einsum("nij,nj->ni", self._before_matrix, inner)
        out[:, 3:] = _product(turned, self._after)
        return out


def _quaternions(transforms: list[pin.SE3]) -> np.ndarray:
    return np.array([pin.SE3ToXYZQUAT(T)[3:] for T in transforms]).reshape(-1, 4)


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the Hamilton product of quaternions x y z w, row by row."""
    va, wa, vb, wb = a[:, :3], a[:, 3:], b[:, :3], b[:, 3:]
    scalar = wa * wb - (va * vb).sum(axis=1, keepdims=True)
    return np.concatenate((wa * vb + wb * va + _cross(va, vb), scalar), axis=1)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    crossed: np.ndarray = a[:, _YZX] * b[:, _ZXY] - a[:, _ZXY] * b[:, _YZX]
    return crossed


def _rotate(q: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Rotate vectors by quaternions, row by row: x + 2 v × (v × x + w x)."""
    v, w = q[:, :3], q[:, 3:]
    turned: np.ndarray = x + 2.0 * _cross(v, _cross(v, x) + w * x)
    return turned


class MovingLinkTransforms(MessageTopic):
    """`/tf`: the base in `odom`, and all links that move relative to their parents.

    Args:
        robot: Robot of the ticks.
        where: Function that returns a mask of the ticks of a batch with a message, shape (n,).
    """

    name = "/tf"
    type_name = _TYPE

    def __init__(self, robot: Robot, where: Callable[[TickBatch], np.ndarray]) -> None:
        moving = [link for link in links(robot) if link.joint is not None]
        self._moving, self._where = MovingLinks(moving), where
        names = [(ODOM, robot.base), *((link.parent, link.name) for link in moving)]
        self._template, self._numbers, self._indices = _laid_out(names)

    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """Return the messages of a batch; see `MessageTopic.messages`."""
        found = []
        for index in np.flatnonzero(self._where(batch)).tolist():
            q = batch.records["q"][index]
            self._numbers[self._indices[:7]] = q[:7]
            self._numbers[self._indices[7:]] = self._moving.at(q[7:]).ravel()
            self._template.stamp_nanoseconds(int(batch.stamps[index]))
            found.append(TopicMessage(index, self._template.encode()))
        return found


class FixedLinkTransforms(LatchedTopic):
    """`/tf_static`: the links that are fixed to their parents, and the soles.

    Args:
        robot: Robot of the ticks.
    """

    name = "/tf_static"
    type_name = _TYPE

    def __init__(self, robot: Robot) -> None:
        fixed = [link for link in links(robot) if link.joint is None]
        self._template, numbers, indices = _laid_out([(link.parent, link.name) for link in fixed])
        poses = [pin.SE3ToXYZQUAT(link.before * link.after) for link in fixed]
        numbers[indices] = np.array(poses).ravel()

    def encode(self) -> bytes:
        """Return the message, CDR."""
        return self._template.encode()


def _laid_out(names: list[tuple[str, str]]) -> tuple[Template, np.ndarray, np.ndarray]:
    """Return a message template, its 8-byte words, and the indices of each transform's seven."""
    transform = message_type("geometry_msgs/msg/TransformStamped")
    message = message_type(_TYPE)()
    for parent, child in names:
        one = transform(child_frame_id=child)
        one.header.frame_id = parent
        message.transforms.append(one)
    template = Template(message)
    words = (len(template.data) - _CDR_HEADER) // 8
    numbers = np.frombuffer(template.data, np.float64, words, _CDR_HEADER)
    starts = [
        (template.locate(f"transforms[{i}].transform").offset - _CDR_HEADER) // 8
        for i in range(len(names))
    ]
    places = (np.array(starts, dtype=int)[:, None] + np.arange(7)).ravel()
    return template, numbers, places

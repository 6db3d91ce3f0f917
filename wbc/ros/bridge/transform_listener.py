"""Transforms of other nodes, such as that of `odom` in `map` by a localization."""

from __future__ import annotations

from typing import Any

from wbc.geometry.planar import Placement, quaternion_yaw
from wbc.ros.node import Node
from wbc.ros.qos import HIGH_RATE, QoSProfile
from wbc.ros.qos import DurabilityPolicy as Durability

_TYPE = "tf2_msgs/msg/TFMessage"
_STATIC = QoSProfile(depth=100, durability=Durability.TRANSIENT_LOCAL)
_MAX_DEPTH = 100  # of the tree; a message may close a circle


class TransformListener:
    """The latest transforms that other nodes publish on `/tf` and `/tf_static`, seen from above.

    Args:
        node: node that subscribes to the topics.
    """

    def __init__(self, node: Node) -> None:
        self._parents: dict[str, tuple[str, Placement]] = {}
        for topic, qos in (("/tf", HIGH_RATE), ("/tf_static", _STATIC)):
            node.create_subscription(
                _TYPE, topic, self._on_transforms, qos, ignore_local_publications=True
            )

    def _on_transforms(self, message: Any) -> None:
        for one in message.transforms:
            pose = placement_of(one.transform.translation, one.transform.rotation)
            self._parents[_name(one.child_frame_id)] = (_name(one.header.frame_id), pose)

    def transform(self, pose: Placement, source: str, target: str) -> Placement | None:
        """Return a pose given in one frame in another one; None if they are not connected."""
        source_root, in_root = self._from_root(source, pose)
        target_root, origin = self._from_root(target, Placement(0j, 0.0))
        return in_root.relative_to(origin) if source_root == target_root else None

    def _from_root(self, frame: str, pose: Placement) -> tuple[str, Placement]:
        """Return the root of a frame's tree, and a pose given in the frame in the root."""
        frame = _name(frame)
        for _ in range(_MAX_DEPTH):
            if frame not in self._parents:
                break
            frame, relative = self._parents[frame]
            pose = relative.compose(pose)
        return frame, pose


def placement_of(position: Any, orientation: Any) -> Placement:
    """Return the ground point and the yaw of a `Point` or `Vector3` and a `Quaternion`."""
    yaw = quaternion_yaw(orientation.x, orientation.y, orientation.z, orientation.w)
    return Placement(complex(position.x, position.y), yaw)


def _name(frame: str) -> str:
    return frame.lstrip("/")

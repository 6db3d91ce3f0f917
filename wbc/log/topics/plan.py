"""What the gait intends: support polygon, footsteps and the swing foot's path."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from wbc.log.topics.block import Block
from wbc.log.topics.topic import Topic, TopicMessage
from wbc.messages import Message, message_type

_SIDES = ("left", "right")
_Header = message_type("std_msgs/Header")
_Pose = message_type("geometry_msgs/Pose")


class PlanTopic(Topic):
    """A topic of the ticks that carry a plan, some 30 per second."""

    def messages(self, block: Block) -> list[TopicMessage]:
        """See `Topic.messages`."""
        found = []
        for index in np.flatnonzero(block.records["planned"]):
            header = _Header(frame_id="world")
            stamp = divmod(int(block.stamps[index]), 1_000_000_000)
            header.stamp.sec, header.stamp.nanosec = stamp
            message = self._message(block.records[index], header)
            found.append(TopicMessage(int(index), message.encode()))
        return found

    @abstractmethod
    def _message(self, record: Any, header: Message) -> Message:
        """The message of one tick."""


class SupportPolygon(PlanTopic):
    """On what the robot stands, counter-clockwise."""

    name = "/support_polygon"
    type_name = "geometry_msgs/msg/PolygonStamped"

    def _message(self, record: Any, header: Message) -> Message:
        message = message_type(self.type_name)(header=header)
        point = message_type("geometry_msgs/Point32")
        corners = record["support"].reshape(-1, 3)[: int(record["support_size"])]
        message.polygon.points = [point(x=x, y=y, z=z) for x, y, z in corners.tolist()]
        return message


class Footsteps(PlanTopic):
    """Planned steps, the next one first."""

    name = "/footsteps"
    type_name = "wbc_msgs/msg/FootstepPlan"

    def _message(self, record: Any, header: Message) -> Message:
        step = message_type("wbc_msgs/Footstep")
        steps = [step(side=int(row[0]), pose=_pose(row)) for row in _steps(record)]
        return message_type(self.type_name)(header=header, footsteps=steps)


class FootstepsOfSide(PlanTopic):
    """The same for one side, of a type that viewers draw.

    Args:
        side: "left" or "right".
    """

    type_name = "geometry_msgs/msg/PoseArray"

    def __init__(self, side: str) -> None:
        self.name = f"/footsteps/{side}"
        self._side = _SIDES.index(side)

    def _message(self, record: Any, header: Message) -> Message:
        poses = [_pose(row) for row in _steps(record) if int(row[0]) == self._side]
        return message_type(self.type_name)(header=header, poses=poses)


class SwingPath(PlanTopic):
    """The way of the swing sole's centre still to go."""

    name = "/swing_path"
    type_name = "nav_msgs/msg/Path"

    def _message(self, record: Any, header: Message) -> Message:
        stamped = message_type("geometry_msgs/PoseStamped")
        points = record["swing"].reshape(-1, 3)[: int(record["swing_size"])]
        poses = [stamped(header=header, pose=_pose((0, *p, 0.0))) for p in points.tolist()]
        return message_type(self.type_name)(header=header, poses=poses)


def _steps(record: Any) -> list[list[float]]:
    rows = record["footsteps"].reshape(-1, 5)[: int(record["footsteps_size"])]
    steps: list[list[float]] = rows.tolist()
    return steps


def _pose(row: Any) -> Message:
    """Of `[side, x, y, z, yaw]`."""
    pose = _Pose()
    pose.position.x, pose.position.y, pose.position.z = row[1:4]
    pose.orientation.z = float(np.sin(0.5 * row[4]))
    pose.orientation.w = float(np.cos(0.5 * row[4]))
    return pose

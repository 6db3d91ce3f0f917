"""Topics of the contact plan: support polygon, footsteps and the swing foot's path."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from wbc.messages import Message, message_type
from wbc.runtime.record import contact_plan_of
from wbc.runtime.schema import ODOM
from wbc.telemetry import SIDES, ContactPlan, Footstep
from wbc.topics.batch import TickBatch
from wbc.topics.message_topic import MessageTopic, TopicMessage

_Header = message_type("std_msgs/Header")
_Pose = message_type("geometry_msgs/Pose")


class ContactPlanTopic(MessageTopic):
    """A topic with one message per new contact plan, about 30 per second."""

    _latest = (0.0, 0.0)  # run and tick of the latest published plan

    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """Return the messages of a batch; see `MessageTopic.messages`."""
        records = batch.records
        plans = zip(records["run"].tolist(), records["contact_plan_tick"].tolist(), strict=True)
        found = []
        for index, plan in enumerate(plans):
            if plan == self._latest or np.isnan(plan[1]):
                continue
            self._latest = plan
            header = _Header(frame_id=ODOM)
            header.stamp.sec, header.stamp.nanosec = divmod(int(batch.stamps[index]), 1_000_000_000)
            message = self._message(contact_plan_of(records[index]), header)
            found.append(TopicMessage(index, message.encode()))
        return found

    @abstractmethod
    def _message(self, plan: ContactPlan, header: Message) -> Message:
        """Return the message of one contact plan."""


class SupportPolygonTopic(ContactPlanTopic):
    """Publishes the support polygon, with counter-clockwise vertices."""

    name = "support_polygon"
    type_name = "geometry_msgs/msg/PolygonStamped"

    def _message(self, plan: ContactPlan, header: Message) -> Message:
        message = message_type(self.type_name)(header=header)
        point = message_type("geometry_msgs/Point32")
        message.polygon.points = [point(x=x, y=y, z=z) for x, y, z in plan.support.tolist()]
        return message


class FootstepsTopic(ContactPlanTopic):
    """Publishes the planned footsteps, the next one first."""

    name = "footsteps"
    type_name = "wbc_msgs/msg/FootstepPlan"

    def _message(self, plan: ContactPlan, header: Message) -> Message:
        footstep = message_type("wbc_msgs/Footstep")
        steps = [footstep(side=SIDES.index(s.side), pose=_pose(s)) for s in plan.footsteps]
        return message_type(self.type_name)(header=header, footsteps=steps)


class SideFootstepsTopic(ContactPlanTopic):
    """Publishes the planned footsteps of one side, as a message type that viewers draw.

    Args:
        side: "left" or "right".
    """

    type_name = "geometry_msgs/msg/PoseArray"

    def __init__(self, side: str) -> None:
        self.name = f"footsteps/{side}"
        self._side = side

    def _message(self, plan: ContactPlan, header: Message) -> Message:
        poses = [_pose(step) for step in plan.footsteps if step.side == self._side]
        return message_type(self.type_name)(header=header, poses=poses)


class SwingPathTopic(ContactPlanTopic):
    """Publishes the remaining path of the swing sole's centre."""

    name = "swing_path"
    type_name = "nav_msgs/msg/Path"

    def _message(self, plan: ContactPlan, header: Message) -> Message:
        stamped = message_type("geometry_msgs/PoseStamped")
        poses = [
            stamped(header=header, pose=_pose(Footstep("left", point, 0.0)))
            for point in plan.swing_path
        ]
        return message_type(self.type_name)(header=header, poses=poses)


def _pose(step: Footstep) -> Any:
    pose = _Pose()
    pose.position.x, pose.position.y, pose.position.z = step.position.tolist()
    pose.orientation.z = float(np.sin(0.5 * step.yaw))
    pose.orientation.w = float(np.cos(0.5 * step.yaw))
    return pose

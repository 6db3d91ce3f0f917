"""Topics of the contact plan: support polygon, footsteps and the swing foot's path."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from wbc.messages import message_type
from wbc.runtime.record import contact_plan_of
from wbc.runtime.schema import ODOM
from wbc.telemetry import SIDES, ContactPlan, Footstep
from wbc.topics.batch import TickBatch
from wbc.topics.topic import MessageTopic, TopicMessage


class ContactPlanTopic(MessageTopic):
    """A topic with one message per new contact plan, about 30 per second.

    Args:
        name: Name of the topic.
        type_name: Type of its messages.
        fill: Called with a new message and the plan; the header is already set.
    """

    def __init__(self, name: str, type_name: str, fill: Callable[[Any, ContactPlan], None]) -> None:
        super().__init__(name, type_name)
        self._fill = fill
        self._latest = (0.0, 0.0)  # run and tick of the latest published plan

    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """Return the messages of a batch; see `MessageTopic.messages`."""
        records = batch.records
        plans = zip(records["run"].tolist(), records["contact_plan_tick"].tolist(), strict=True)
        found = []
        for index, plan in enumerate(plans):
            if plan == self._latest or np.isnan(plan[1]):
                continue
            self._latest = plan
            message = message_type(self.type_name)()
            header = message.header
            header.frame_id = ODOM
            header.stamp.sec, header.stamp.nanosec = divmod(int(batch.stamps[index]), 1_000_000_000)
            self._fill(message, contact_plan_of(records[index]))
            found.append(TopicMessage(index, message.encode()))
        return found


def contact_plan_topics() -> list[ContactPlanTopic]:
    """Return the topics of the contact plan."""
    return [
        ContactPlanTopic("support_polygon", "geometry_msgs/msg/PolygonStamped", _fill_support),
        ContactPlanTopic("footsteps", "wbc_msgs/msg/FootstepPlan", _fill_footsteps),
        # The footsteps of each side once more, as a type that viewers draw.
        ContactPlanTopic("footsteps/left", "geometry_msgs/msg/PoseArray", _fill_left),
        ContactPlanTopic("footsteps/right", "geometry_msgs/msg/PoseArray", _fill_right),
        ContactPlanTopic("swing_path", "nav_msgs/msg/Path", _fill_swing_path),
    ]


def _fill_support(message: Any, plan: ContactPlan) -> None:
    """Fill in the support polygon, with counter-clockwise vertices."""
    point = message_type("geometry_msgs/msg/Point32")
    message.polygon.points = [point(x=x, y=y, z=z) for x, y, z in plan.support]


def _fill_footsteps(message: Any, plan: ContactPlan) -> None:
    """Fill in the planned footsteps, the next one first."""
    footstep = message_type("wbc_msgs/msg/Footstep")
    message.footsteps = [
        footstep(side=SIDES.index(step.side), pose=_pose(step)) for step in plan.footsteps
    ]


def _fill_left(message: Any, plan: ContactPlan) -> None:
    message.poses = [_pose(step) for step in plan.footsteps if step.side == "left"]


def _fill_right(message: Any, plan: ContactPlan) -> None:
    message.poses = [_pose(step) for step in plan.footsteps if step.side == "right"]


def _fill_swing_path(message: Any, plan: ContactPlan) -> None:
    """Fill in the remaining path of the swing sole's centre."""
    stamped = message_type("geometry_msgs/msg/PoseStamped")
    steps = (Footstep("left", point, 0.0) for point in plan.swing_path)
    message.poses = [stamped(header=message.header, pose=_pose(step)) for step in steps]


def _pose(step: Footstep) -> Any:
    pose = message_type("geometry_msgs/msg/Pose")()
    pose.position.x, pose.position.y, pose.position.z = step.position
    pose.orientation.z, pose.orientation.w = np.sin(0.5 * step.yaw), np.cos(0.5 * step.yaw)
    return pose

"""The topic `goal_pose`, on which RViz's tool "2D Goal Pose" publishes: a goal of the action."""

from __future__ import annotations

from typing import Any

from wbc.ros.actions import ActionClient
from wbc.ros.bridge.navigate_to_pose import NAME, TYPE
from wbc.ros.node import Node


class GoalPose:
    """Sends the poses of the topic as goals to the node's own action `navigate_to_pose`, as Nav2.

    The action logs why it rejects a goal, on `/rosout` as well.

    Args:
        node: node that subscribes to the topic and serves the action.
    """

    def __init__(self, node: Node) -> None:
        self._client = ActionClient(node, TYPE, NAME)
        node.create_subscription("geometry_msgs/msg/PoseStamped", "goal_pose", self._on_pose)

    def _on_pose(self, pose: Any) -> None:
        self._client.send_goal_async(self._client.goal_type(pose=pose))

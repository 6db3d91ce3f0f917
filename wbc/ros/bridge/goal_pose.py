"""The topic `goal_pose`, on which RViz's tool "2D Goal Pose" publishes: a goal of the action."""

from __future__ import annotations

import logging
from concurrent.futures import Future
from typing import Any

from wbc.ros.actions import ActionClient, ClientGoalHandle
from wbc.ros.bridge.navigate_to_pose import NAME, TYPE
from wbc.ros.node import Node

logger = logging.getLogger(__name__)


class GoalPose:
    """Sends the poses of the topic as goals to the node's own action `navigate_to_pose`, as Nav2.

    Args:
        node: node that subscribes to the topic and serves the action.
    """

    def __init__(self, node: Node) -> None:
        self._client = ActionClient(node, TYPE, NAME)
        node.create_subscription("geometry_msgs/msg/PoseStamped", "goal_pose", self._on_pose)

    def _on_pose(self, pose: Any) -> None:
        self._client.send_goal_async(self._client.goal_type(pose=pose)).add_done_callback(_log)


def _log(future: Future[ClientGoalHandle]) -> None:
    if not future.result().accepted:
        logger.warning(
            "goal_pose: rejected the pose: its frame is unknown, it is no pose, or the robot has "
            "fallen"
        )

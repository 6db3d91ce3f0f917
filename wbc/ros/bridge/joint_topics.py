"""The topics `joint_commands` and `joint_trajectory`: positions of arms, trunk and head.

Leg joints are refused, because the gait controls them. `joint_commands` holds positions to move to
at once, `joint_trajectory` positions over time.
"""

from __future__ import annotations

import logging
import time
from typing import Any

import numpy as np

from wbc.ros.node import Node
from wbc.ros.stamp import to_seconds
from wbc.ros.timer import Timer
from wbc.teleop import CommandClient, CommandRefused, JointCommand

logger = logging.getLogger(__name__)

_PERIOD = 0.02  # s between two points of a trajectory that are sent


class JointTopics:
    """Sends joint commands from both topics; the latest one holds for its joints.

    Args:
        node: subscribes to the topics.
        client: sends the commands.
    """

    def __init__(self, node: Node, client: CommandClient) -> None:
        self._node, self._client = node, client
        self._speed = node.declare_parameter(
            "joint_speed",
            1.0,
            "largest velocity of commanded joints, rad/s; at most half their limit",
            minimum=0.01,
            maximum=10.0,
        )
        self._trajectory: tuple[float, list[str], np.ndarray, np.ndarray] | None = None
        self._timer: Timer | None = None
        node.create_subscription("sensor_msgs/msg/JointState", "joint_commands", self._on_joints)
        node.create_subscription(
            "trajectory_msgs/msg/JointTrajectory", "joint_trajectory", self._on_trajectory
        )

    def end_trajectory(self) -> None:
        """Stop sending the points of the trajectory in progress."""
        if self._timer is not None:
            self._timer.cancel()
        self._trajectory = self._timer = None

    def _on_joints(self, message: Any, _: Any) -> None:
        try:
            positions = self._positions(message.name, message.position)
            self.end_trajectory()
            self._send(message.name, positions, 0.0)
        except CommandRefused as error:
            logger.warning("joint_commands: ignored: %s", error)

    def _on_trajectory(self, message: Any, _: Any) -> None:
        try:
            names = message.joint_names
            self._client.capabilities.check_joint_names(names)
            times = np.array([to_seconds(p.time_from_start) for p in message.points])
            if not times.size:
                raise CommandRefused("the trajectory has no points")
            if times[0] < 0.0 or not (np.diff(times) > 0.0).all():
                raise CommandRefused("the times of the points do not increase")
            rows = np.array([self._positions(names, p.positions) for p in message.points])
        except CommandRefused as error:
            logger.warning("joint_trajectory: ignored: %s", error)
            return
        self.end_trajectory()
        self._trajectory = (time.monotonic(), names, times, rows)
        self._timer = self._node.create_timer(_PERIOD, self._follow)
        self._follow()

    def _follow(self) -> None:
        """Send the trajectory's positions a short time ahead."""
        assert self._trajectory is not None
        start, names, times, rows = self._trajectory
        now = time.monotonic()
        arrival = now + _PERIOD
        at = min(max(arrival - start, times[0]), times[-1])
        positions = np.array([np.interp(at, times, column) for column in rows.T])
        # The first point may be far away: the joints move there until its time.
        try:
            self._send(names, positions, max(arrival, start + times[0]) - now)
        except CommandRefused as error:
            logger.warning("joint_trajectory: %s", error)
        if at >= times[-1]:
            self.end_trajectory()

    def _send(self, names: list[str], positions: np.ndarray, duration: float) -> None:
        speed = float(self._speed.value)
        self._client.send(JointCommand(tuple(names), tuple(positions.tolist()), duration, speed))

    def _positions(self, names: list[str], positions: Any) -> np.ndarray:
        """Return the positions, clamped to the limits of the joints.

        Raises:
            CommandRefused: the joints cannot be led, or the positions are not theirs.
        """
        capabilities = self._client.capabilities
        capabilities.check_joint_names(names)
        if len(positions) != len(names):
            raise CommandRefused(f"{len(names)} joints have {len(positions)} positions")
        values = np.asarray(positions, dtype=float)
        if not np.isfinite(values).all():
            raise CommandRefused("a position is not finite")
        low, high = np.array([capabilities.joints[name] for name in names]).T
        return np.clip(values, low, high)

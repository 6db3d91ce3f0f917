"""The topics `joint_commands` and `joint_trajectory`: positions of arms, trunk and head.

`joint_commands` sets positions to move to at once, `joint_trajectory` positions over time. The
joints of the legs are refused, because the gait controls them.
"""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.ros.executor import Timer
from wbc.ros.node import Node
from wbc.ros.stamp import to_seconds
from wbc.teleop import CommandClient, CommandRefused, JointCommand

logger = logging.getLogger(__name__)

_PERIOD = 0.02  # s between two points of a trajectory that are sent


@dataclass(frozen=True, eq=False)
class _Trajectory:
    """Joint positions (points, joints), rad, at times (points,), s on the monotonic clock."""

    joints: list[str]
    times: np.ndarray
    positions: np.ndarray
    timer: Timer


class JointTopics:
    """Sends the joint commands of both topics; the latest command of a joint applies.

    Args:
        node: node that subscribes to the topics.
        client: sends the commands.
    """

    def __init__(self, node: Node, client: CommandClient) -> None:
        self._node, self._client = node, client
        self._max_speed = node.declare_parameter(
            "joint_speed",
            1.0,
            "largest velocity of commanded joints, rad/s; at most half the limit of each joint",
            bounds=(0.01, 10.0),
        )
        self._trajectory: _Trajectory | None = None
        node.create_subscription("sensor_msgs/msg/JointState", "joint_commands", self._on_command)
        node.create_subscription(
            "trajectory_msgs/msg/JointTrajectory", "joint_trajectory", self._on_trajectory
        )

    def cancel_trajectory(self) -> None:
        """Stop sending the points of the trajectory in progress."""
        if self._trajectory is not None:
            self._trajectory.timer.cancel()
        self._trajectory = None

    def _on_command(self, message: Any) -> None:
        try:
            positions = self._clamped(message.name, message.position)
            self.cancel_trajectory()
            self._send(message.name, positions, 0.0)
        except CommandRefused as error:
            logger.warning("joint_commands: ignored a message: %s", error)

    def _on_trajectory(self, message: Any) -> None:
        try:
            joints = message.joint_names
            positions = np.array([self._clamped(joints, p.positions) for p in message.points])
            times = np.array([to_seconds(p.time_from_start) for p in message.points])
            if not times.size:
                raise CommandRefused("the trajectory has no points")
            if times[0] < 0.0 or not (np.diff(times) > 0.0).all():
                raise CommandRefused("the times of the points do not increase")
        except CommandRefused as error:
            logger.warning("joint_trajectory: ignored a message: %s", error)
            return
        self.cancel_trajectory()
        timer = self._node.create_timer(_PERIOD, self._send_next_point)
        self._trajectory = _Trajectory(joints, time.monotonic() + times, positions, timer)
        self._send_next_point()

    def _send_next_point(self) -> None:
        """Send the positions that the trajectory has one period from now."""
        trajectory = self._trajectory
        if trajectory is None:
            return
        now, times = time.monotonic(), trajectory.times
        # The joints may be far from the first point: they have until its time to reach it.
        arrival = max(now + _PERIOD, times[0])
        positions = np.array([np.interp(arrival, times, q) for q in trajectory.positions.T])
        try:
            self._send(trajectory.joints, positions, arrival - now)
        except CommandRefused as error:
            logger.warning("joint_trajectory: %s", error)
        if arrival >= times[-1]:
            self.cancel_trajectory()

    def _send(self, joints: list[str], positions: np.ndarray, duration: float) -> None:
        values = tuple(positions.tolist())
        self._client.send(JointCommand(tuple(joints), values, duration, self._max_speed.value))

    def _clamped(self, joints: list[str], positions: Any) -> np.ndarray:
        """Return the positions, clamped to the limits of the joints.

        Raises:
            CommandRefused: a joint cannot be commanded, or its position is missing or not finite.
        """
        capabilities = self._client.capabilities
        capabilities.check_joint_names(joints)
        if len(positions) != len(joints):
            raise CommandRefused(f"{len(joints)} joints have {len(positions)} positions")
        if not np.isfinite(positions).all():
            raise CommandRefused("a position is not finite")
        lower, upper = np.array([capabilities.joints[name] for name in joints]).T
        clamped: np.ndarray = np.clip(positions, lower, upper)
        return clamped

"""The topics `joint_commands` and `joint_trajectory`: positions of arms, trunk and head.

`joint_commands` sets positions to move to at once, `joint_trajectory` positions over time. The
joints of the legs are refused, because the gait controls them.
"""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wbc.robot import Robot
from wbc.ros.bridge.joint_trajectory import JointTrajectory
from wbc.ros.executor import Timer
from wbc.ros.node import Node
from wbc.teleop import CommandClient, CommandRefused, JointCommand
from wbc.teleop.joint_targets import SPEED_SHARE

logger = logging.getLogger(__name__)

_PERIOD = 0.02  # s between two points of a trajectory that are sent


@dataclass(frozen=True, eq=False)
class TrajectoryExecution:
    """A trajectory in progress.

    Attributes:
        trajectory: the trajectory.
        start: time of its start, s on the monotonic clock.
        timer: sends its points.
    """

    trajectory: JointTrajectory
    start: float
    timer: Timer

    @property
    def elapsed(self) -> float:
        """Time since its start, s."""
        return time.monotonic() - self.start


class JointTopics:
    """Sends the joint commands of both topics; the latest command of a joint applies.

    A trajectory keeps its times and velocities: one that needs more than the joints are given,
    half of their velocity limits, is refused.

    Args:
        node: node that subscribes to the topics.
        client: sends the commands.
        robot: the robot.

    Attributes:
        execution: the trajectory in progress, or the last one that was not interrupted.
    """

    def __init__(self, node: Node, client: CommandClient, robot: Robot) -> None:
        self._node, self._client = node, client
        self._speed_limits = dict(zip(robot.joint_names, SPEED_SHARE * robot.v_max, strict=True))
        self._max_speed = node.declare_parameter(
            "joint_speed",
            1.0,
            "largest velocity of commanded joints, and of the way to the first point of a "
            "trajectory, rad/s; at most half the limit of each joint",
            bounds=(0.01, 10.0),
        )
        self.execution: TrajectoryExecution | None = None
        node.create_subscription("sensor_msgs/msg/JointState", "joint_commands", self._on_command)
        node.create_subscription(
            "trajectory_msgs/msg/JointTrajectory", "joint_trajectory", self._on_trajectory
        )

    def cancel_trajectory(self) -> None:
        """Stop sending the points of the trajectory in progress."""
        if self.execution is not None:
            self.execution.timer.cancel()
        self.execution = None

    def _on_command(self, message: Any) -> None:
        try:
            positions = self._clamped(message.name, message.position)
            self.cancel_trajectory()
            self._send(message.name, positions, 0.0, self._max_speed.value)
        except CommandRefused as error:
            logger.warning("joint_commands: ignored a message: %s", error)

    def _on_trajectory(self, message: Any) -> None:
        try:
            self.execute(self.parse(message))
        except CommandRefused as error:
            logger.warning("joint_trajectory: ignored a message: %s", error)

    def parse(self, message: Any) -> JointTrajectory:
        """Return the trajectory of a message, clamped to the limits of the joints.

        Raises:
            CommandRefused: a joint cannot be commanded, or not as fast, or the message is invalid.
        """
        self._client.capabilities.check_joint_names(message.joint_names)
        found = JointTrajectory.parse(message)
        found.check_velocity(np.array([self._speed_limits[name] for name in found.joints]))
        clamped = np.array([self._clamped(found.joints, row) for row in found.positions])
        return replace(found, positions=clamped)

    def execute(self, trajectory: JointTrajectory) -> TrajectoryExecution:
        """Follow a trajectory from now on."""
        self.cancel_trajectory()
        timer = self._node.create_timer(_PERIOD, self._send_next_point)
        execution = self.execution = TrajectoryExecution(trajectory, time.monotonic(), timer)
        self._send_next_point()
        return execution

    def _send_next_point(self) -> None:
        """Send the positions that the trajectory has one period from now."""
        execution = self.execution
        if execution is None:
            return
        trajectory, now = execution.trajectory, execution.elapsed
        # The joints may be far from the first point: they have until its time to reach it.
        approaching = now + _PERIOD <= trajectory.times[0] or now < _PERIOD
        arrival = max(now + _PERIOD, trajectory.times[0])
        max_speed = self._max_speed.value if approaching else np.inf
        try:
            self._send(trajectory.joints, trajectory.at(arrival), arrival - now, max_speed)
        except CommandRefused as error:
            logger.warning("joint_trajectory: %s", error)
        if arrival >= trajectory.times[-1]:
            execution.timer.cancel()

    def _send(self, joints: Any, positions: np.ndarray, duration: float, max_speed: float) -> None:
        values = tuple(positions.tolist())
        self._client.send(JointCommand(tuple(joints), values, duration, max_speed))

    def _clamped(self, joints: Any, positions: Any) -> np.ndarray:
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

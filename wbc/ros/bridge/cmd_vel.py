"""The topic `cmd_vel`: a velocity command that expires unless it is renewed.

It takes `Twist` and, as Nav2 and the teleoperation nodes of Jazzy may send, `TwistStamped`.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from typing import Any

from wbc.ros.node import Node
from wbc.teleop import CommandClient, CommandRefused, VelocityCommand

logger = logging.getLogger(__name__)


class CmdVel:
    """Sends velocity commands: those of messages on `cmd_vel`, and those of actions that walk.

    Args:
        node: node that subscribes to the topic.
        client: sends the commands.

    Attributes:
        max_velocity: the velocities that the robot walks at.
        step_duration: usual duration of a step, s.
        on_override: called when a message on `cmd_vel` takes over from an action that walks.
    """

    def __init__(self, node: Node, client: CommandClient) -> None:
        self._client = client
        capabilities = client.capabilities
        self.max_velocity = capabilities.max_velocity
        self.step_duration = sum(
            capabilities.parameter(f"gait.{name}").default
            for name in ("single_support", "double_support")
        )
        self._timeout = node.declare_parameter(
            "cmd_vel_timeout", 0.5, "validity of a message on cmd_vel, s", bounds=(0.05, 10.0)
        )
        self.on_override: Callable[[], None] = lambda: None
        node.create_subscription("geometry_msgs/msg/Twist", "cmd_vel", self._on_twist)
        node.create_subscription(
            "geometry_msgs/msg/TwistStamped",
            "cmd_vel",
            lambda message: self._on_twist(message.twist),
        )

    def _on_twist(self, message: Any) -> None:
        velocity = (message.linear.x, message.linear.y, message.angular.z)
        if not all(map(math.isfinite, velocity)):
            logger.warning("cmd_vel: ignored %s, which is not finite", velocity)
            return
        if any(velocity):
            self.on_override()
        self.walk(velocity, self._timeout.value)

    def walk(self, velocity: tuple[float, float, float], timeout: float) -> None:
        """Walk at a velocity, clamped to the limits of the gait.

        Args:
            velocity: forward, left (m/s) and turn (rad/s).
            timeout: time after which the robot stops, s.
        """
        forward, left, turn = self.max_velocity.clamp(*velocity)
        try:
            self._client.send(VelocityCommand(forward, left, turn, timeout))
        except CommandRefused as error:
            logger.warning("velocity command: %s", error)

    def stand(self) -> None:
        """Stop walking."""
        self.walk((0.0, 0.0, 0.0), 0.0)

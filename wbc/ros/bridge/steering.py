"""`/cmd_vel`: a velocity for as long as somebody keeps wanting it."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from typing import Any

from wbc.ros.bridge.mailbox import Mailbox, Orders
from wbc.ros.bridge.order import Order
from wbc.ros.node import Node

logger = logging.getLogger(__name__)

Velocity = tuple[float, float, float]
STANDING: Velocity = (0.0, 0.0, 0.0)


class Steering:
    """Takes velocities from `cmd_vel` and from whoever walks by itself.

    Attributes:
        max_velocity: largest |forward|, |left| (m/s) and |turn| (rad/s).
        taken_over: called when somebody steers by hand.
        sets_out: called when the robot is to walk, whoever wants it.
    """

    def __init__(self, node: Node, orders: Orders, mailbox: Mailbox, order: Order) -> None:
        self._orders, self._mailbox = orders, mailbox
        self.max_velocity = order.max_velocity
        self._timeout = node.declare_parameter(
            "cmd_vel_timeout",
            0.5,
            "after which the robot stops when no cmd_vel comes, s",
            minimum=0.05,
            maximum=10.0,
        )
        self.taken_over: Callable[[], None] = lambda: None
        self.sets_out: Callable[[], None] = lambda: None
        node.create_subscription("geometry_msgs/msg/Twist", "cmd_vel", self._hear)

    def _hear(self, message: Any, _: Any) -> None:
        wanted = (message.linear.x, message.linear.y, message.angular.z)
        if not all(map(math.isfinite, wanted)):
            logger.warning("cmd_vel %s is not finite: ignored", wanted)
            return
        if wanted != STANDING:
            self.taken_over()
        self.walk(wanted, float(self._timeout.value))

    def walk(self, velocity: Velocity, lasting: float) -> None:
        """Walk at a velocity, clamped to what the gait can do, for so many s at the most."""
        x, y, turn = (
            max(-most, min(most, value))
            for value, most in zip(velocity, self.max_velocity, strict=True)
        )
        if velocity != STANDING:
            self.sets_out()
        self._orders.velocity = (x, y, turn)
        self._orders.velocity_until = time.monotonic() + lasting
        self._mailbox.post(self._orders)

    def stand(self) -> None:
        """Come to a stand."""
        self.walk(STANDING, 0.0)

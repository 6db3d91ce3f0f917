"""Services that need a simulator: `push` and `reset_robot`.

Both are `std_srvs/Trigger`, which every ROS 2 system has: an impulse of its own kind would have
to be built there first. So the push's impulse and duration are parameters.
"""

from __future__ import annotations

import time
from typing import Any

from wbc.messages import message_type
from wbc.ros.bridge.mailbox import Mailbox, Orders
from wbc.ros.bridge.order import Order
from wbc.ros.node import Node
from wbc.ros.services import ServiceReply

_TYPE = "std_srvs/srv/Trigger"
_PATIENCE = 5.0  # s for the loop to start over


class PlantRequests:
    """Serves both."""

    def __init__(self, node: Node, orders: Orders, mailbox: Mailbox, order: Order) -> None:
        self._orders, self._mailbox, self._order = orders, mailbox, order
        self._response = message_type(f"{_TYPE}_Response")
        largest = 2.0 * order.robot.mass  # N·s: 2 m/s, which no robot survives
        self._impulse = node.declare_parameter(
            "push_impulse",
            (0.0, round(0.1 * order.robot.mass, 1), 0.0),
            "of a push on the torso, N·s, axes of odom",
            minimum=-largest,
            maximum=largest,
        )
        self._duration = node.declare_parameter(
            "push_duration", 0.1, "of a push, s", minimum=0.01, maximum=2.0
        )
        self._waiting: list[tuple[float, ServiceReply]] = []
        node.create_service(_TYPE, "push", self._push)
        node.create_deferred_service(_TYPE, "reset_robot", self._reset)
        node.create_timer(0.1, self._give_up)

    def _push(self, _: Any, response: Any) -> Any:
        if not self._order.may_push:
            response.message = "this robot cannot be pushed"
            return response
        self._orders.pushes += 1
        self._orders.impulse = tuple(self._impulse.value)
        self._orders.push_duration = float(self._duration.value)
        self._mailbox.post(self._orders)
        x, y, z = self._impulse.value
        response.success = True
        response.message = f"({x:g}, {y:g}, {z:g}) N·s over {self._duration.value:g} s"
        return response

    def _reset(self, _: Any, reply: ServiceReply) -> None:
        if not self._order.may_reset:
            reply.send(self._response(success=False, message="this robot cannot be reset"))
            return
        self._orders.resets += 1
        self._mailbox.post(self._orders)
        self._waiting.append((time.monotonic() + _PATIENCE, reply))

    def reset_done(self) -> None:
        """The loop has started over."""
        waiting, self._waiting = self._waiting, []
        for _, reply in waiting:
            reply.send(self._response(success=True, message="standing"))

    def _give_up(self) -> None:
        now = time.monotonic()
        for until, reply in tuple(self._waiting):
            if now > until:
                self._waiting.remove((until, reply))
                text = f"the loop did not start over in {_PATIENCE:g} s"
                reply.send(self._response(success=False, message=text))

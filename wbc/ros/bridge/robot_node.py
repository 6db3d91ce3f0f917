"""The robot's node: its topics, services, parameters and actions, put together."""

from __future__ import annotations

import logging
from typing import Any

from wbc.messages import message_type
from wbc.process import RecordRing
from wbc.ros.bridge.clock import PlantClock
from wbc.ros.bridge.diagnostics import Diagnostics
from wbc.ros.bridge.layout import Layout, Mode, Sample
from wbc.ros.bridge.mailbox import Mailbox, Orders
from wbc.ros.bridge.order import Order
from wbc.ros.bridge.play_motion import PlayMotion
from wbc.ros.bridge.posture import PostureCommands
from wbc.ros.bridge.requests import PlantRequests
from wbc.ros.bridge.state_topics import BalanceTopics, JointStates, Odometry
from wbc.ros.bridge.steering import Steering
from wbc.ros.bridge.transforms import Transforms
from wbc.ros.bridge.walk_to import WalkTo
from wbc.ros.joint_publisher import MAX_RATE
from wbc.ros.node import Node
from wbc.ros.qos import LATCHED
from wbc.ros.rate_limiter import RateLimiter

logger = logging.getLogger(__name__)

_LEAST_LOOKS = 200.0  # Hz, at which new ticks are looked for
_LEAST_TICKS = 50.0  # Hz, for the steering


class RobotNode:
    """All that the robot's node does.

    Args:
        node: whose topics, services and so on.
        order: about the robot.
        ring: where its ticks come from.
        mailbox: where its orders go.
    """

    def __init__(self, node: Node, order: Order, ring: RecordRing, mailbox: Mailbox) -> None:
        self._ring, self._layout = ring, Layout.of(order.robot)
        self._node = node
        rate = node.declare_parameter(
            "update_rate",
            float(order.update_rate),
            "of joint_states, Hz",
            minimum=1.0,
            maximum=MAX_RATE,
        )
        others = node.declare_parameter(
            "state_rate",
            50.0,
            "of tf, odom, wrenches, com, dcm and zmp, Hz",
            minimum=1.0,
            maximum=MAX_RATE,
        )
        self._rate, self._others = rate, others
        # What can be reset is a simulation.
        self._clock = PlantClock(node, order.use_sim_time) if order.may_reset else None
        self._joint_states = JointStates(node, order.robot)
        self._due = RateLimiter(rate.value, 0.5 * order.dt)
        self._at_state_rate = (
            Odometry(node, order.robot),
            BalanceTopics(node, order.robot),
            Transforms(node, order.robot),
        )
        self._state_due = RateLimiter(others.value, 0.5 * order.dt)
        self._diagnostics = Diagnostics(node, order)
        text = message_type("std_msgs/msg/String")
        description = node.create_publisher(text.type_name, "robot_description", LATCHED)
        description.publish(text(data=order.robot.urdf_path.read_text("utf-8", "replace")))
        orders = Orders.none(order.robot.na)
        self._steering = Steering(node, orders, mailbox, order)
        self._posture = PostureCommands(node, orders, mailbox, order.robot)
        self._requests = PlantRequests(node, orders, mailbox, order)
        self._walk_to = WalkTo(node, self._steering, order)
        self._play = PlayMotion(node, self._steering, self._walk_to, orders, mailbox, order)
        self._orders, self._mailbox = orders, mailbox
        self._latest: Sample | None = None
        self._looks = node.create_timer(1.0 / _LEAST_LOOKS, self._look)
        self._change_rates(None)
        for parameter in (rate, others):
            parameter.on_change = self._change_rates

    def _change_rates(self, _: Any) -> None:
        # Both at once: where the rates are the same, the stamps are, as ExactTime filters need it.
        self._due.restart(self._rate.value)
        self._state_due.restart(self._others.value)
        fastest = float(max(self._rate.value, self._others.value))
        self._looks.period = 1.0 / max(2.0 * fastest, _LEAST_LOOKS)
        self._orders.rate = max(fastest, _LEAST_TICKS)
        self._mailbox.post(self._orders)

    def _look(self) -> None:
        """Take in new ticks."""
        for record in self._ring.read():
            self._take(Sample.of(self._layout, record))

    def _take(self, sample: Sample) -> None:
        if self._clock is not None:
            sample = self._clock.stamped(sample)
        if self._latest is not None:
            self._note_changes(self._latest, sample)
        self._latest = sample
        self._diagnostics.take(sample)
        self._play.take(sample)
        if self._due.is_due(sample.stamp):
            self._joint_states.publish(sample)
        if self._state_due.is_due(sample.stamp):
            for topics in self._at_state_rate:
                topics.publish(sample)
        self._walk_to.take(sample)

    def _note_changes(self, before: Sample, now: Sample) -> None:
        if now.run != before.run:
            logger.info("the robot was reset")
            self._posture.forget()
            self._requests.reset_done()
        elif now.mode is Mode.FALLEN and before.mode is not Mode.FALLEN:
            logger.error("the robot fell")

    def stop(self) -> None:
        """The loop ends."""
        for action in (self._walk_to, self._play):
            action.stop("the robot's loop has ended")

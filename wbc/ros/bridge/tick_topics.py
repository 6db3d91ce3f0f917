"""Publishes the topics of `wbc.topics`: the same that the log has."""

from __future__ import annotations

import numpy as np

from wbc.robot import Robot
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.node import Node
from wbc.ros.publisher import Publisher
from wbc.ros.qos import HIGH_RATE, LATCHED, TF
from wbc.ros.rate_limiter import RateLimiter
from wbc.runtime.record import contact_names
from wbc.runtime.schema import Schema
from wbc.topics import (
    BatchMaker,
    CommandedWrench,
    LatchedTopic,
    MessageTopic,
    latched_topics,
    tick_topics,
)

_JOINT_STATES = "joint_states"


class TickTopics:
    """Publishes ticks: `joint_states` at one rate, all other topics at another.

    Topics that nobody subscribes to are not encoded.

    Args:
        node: publishes the topics.
        robot: the robot of the ticks.
        update_rate: of `joint_states`, Hz.
        state_rate: of the others, Hz.
        tolerance: a tick that precedes its due time by less than this, s, is published.
    """

    def __init__(
        self, node: Node, robot: Robot, update_rate: float, state_rate: float, tolerance: float
    ) -> None:
        self._node, self._robot = node, robot
        self._batches = BatchMaker(robot)
        self._update_due = RateLimiter(update_rate, tolerance)
        self._state_due = RateLimiter(state_rate, tolerance)
        self._schema: Schema | None = None
        self._joint_states: list[tuple[MessageTopic, Publisher]] = []
        self._others: list[tuple[MessageTopic, Publisher]] = []
        self._publishers: dict[str, Publisher] = {}
        self._contacts: set[str] = set()
        for topic in latched_topics(robot):
            self._publisher(topic).publish(topic.encode())

    def change_rates(self, update_rate: float, state_rate: float) -> None:
        """Publish the next tick, and from there on at new rates, Hz.

        Where the rates are the same, the stamps are, as time synchronisers need it.
        """
        self._update_due.restart(update_rate)
        self._state_due.restart(state_rate)

    def attach(self, schema: Schema) -> None:
        """Publish the quantities of a stream from now on; an empty schema changes nothing."""
        if schema is self._schema or not schema.columns:
            return
        self._schema, self._contacts = schema, set()
        topics = tick_topics(schema, self._robot, period=0.0)
        pairs = [(t, self._publisher(t)) for t in topics if not isinstance(t, LatchedTopic)]
        self._joint_states = [pair for pair in pairs if pair[0].name == _JOINT_STATES]
        self._others = [pair for pair in pairs if pair[0].name != _JOINT_STATES]

    def publish(self, tick: StampedTick) -> None:
        """Publish what is due of a tick."""
        for name in sorted(contact_names(tick.record) - self._contacts):
            self._contacts.add(name)
            wrench = CommandedWrench(name)
            self._others.append((wrench, self._publisher(wrench)))
        due = self._joint_states if self._update_due.is_due(tick.stamp) else []
        if self._state_due.is_due(tick.stamp):
            due = due + self._others
        wanted = [pair for pair in due if pair[1].get_subscription_count()]
        if not wanted:
            return
        batch = self._batches.batch(tick.record, np.array([round(1e9 * tick.stamp)]))
        for topic, publisher in wanted:
            for message in topic.messages(batch):
                publisher.publish(message.data)

    def _publisher(self, topic: MessageTopic) -> Publisher:
        known = self._publishers.get(topic.name)
        if known is not None:
            return known
        qos = LATCHED if topic.latched else TF if topic.name == "/tf" else HIGH_RATE
        publisher = self._node.create_publisher(topic.type_name, topic.name, qos)
        self._publishers[topic.name] = publisher
        return publisher

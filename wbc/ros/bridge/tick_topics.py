"""Publishes the topics of `wbc.topics`, which the log has as well."""

from __future__ import annotations

import numpy as np

from wbc.ros.bridge.config import NodeConfig
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.joint_publisher import RATE_BOUNDS
from wbc.ros.node import Node
from wbc.ros.qos import HIGH_RATE, LATCHED
from wbc.ros.topics import Publisher
from wbc.runtime.rate_limiter import RateLimiter
from wbc.runtime.schema import Schema
from wbc.topics import (
    BatchMaker,
    CommandedWrenchTopics,
    LatchedTopic,
    MessageTopic,
    latched_topics,
    tick_topics,
)

_JOINT_STATES = "joint_states"


class TickTopics:
    """Publishes ticks: `joint_states` at `update_rate`, all other topics at `state_rate`.

    Topics without subscriptions are not encoded.

    Args:
        node: node that publishes the topics; it gets the two parameters.
        config: configuration of the node's process.
    """

    def __init__(self, node: Node, config: NodeConfig) -> None:
        self._node, self._robot = node, config.robot
        self._batches = BatchMaker(config.robot)
        self._update_rate = node.declare_parameter(
            "update_rate", config.update_rate, "rate of joint_states, Hz", bounds=RATE_BOUNDS
        )
        self._state_rate = node.declare_parameter(
            "state_rate", 50.0, "rate of tf, odom, balance/com and so on, Hz", bounds=RATE_BOUNDS
        )
        self._update_limiter = RateLimiter(self._update_rate.value, 0.5 * config.dt)
        self._state_limiter = RateLimiter(self._state_rate.value, 0.5 * config.dt)
        self._update_rate.on_change = self._state_rate.on_change = self._restart
        self._schema: Schema | None = None
        self._topics: list[tuple[MessageTopic, Publisher]] = []
        self._publishers: dict[str, Publisher] = {}
        self._wrench_topics = CommandedWrenchTopics()
        for topic in latched_topics(config.robot):
            self._publisher(topic).publish(topic.data)

    @property
    def max_rate(self) -> float:
        """The larger one of both rates, Hz."""
        return float(max(self._update_rate.value, self._state_rate.value))

    def _restart(self, _: float) -> None:
        """Publish the next tick on all topics, so that topics of equal rates have equal stamps."""
        self._update_limiter.restart(self._update_rate.value)
        self._state_limiter.restart(self._state_rate.value)

    def attach(self, schema: Schema) -> None:
        """Publish the quantities of a stream from now on; an empty schema changes nothing."""
        if schema is self._schema or not schema.columns:
            return
        self._schema, self._wrench_topics = schema, CommandedWrenchTopics()
        topics = tick_topics(schema, self._robot, period=0.0)
        self._topics = [(t, self._publisher(t)) for t in topics if not isinstance(t, LatchedTopic)]

    def publish(self, tick: StampedTick) -> None:
        """Publish a tick on the topics that are due."""
        wrench_topics = self._wrench_topics.new_in(tick.record)
        self._topics += [(topic, self._publisher(topic)) for topic in wrench_topics]
        update_due = self._update_limiter.is_due(tick.stamp)
        state_due = self._state_limiter.is_due(tick.stamp)
        subscribed = [
            (topic, publisher)
            for topic, publisher in self._topics
            if (update_due if topic.name == _JOINT_STATES else state_due)
            and publisher.get_subscription_count()
        ]
        if not subscribed:
            return
        batch = self._batches.batch(tick.record, np.array([round(1e9 * tick.stamp)]))
        for topic, publisher in subscribed:
            for message in topic.messages(batch):
                publisher.publish(message.data)

    def _publisher(self, topic: MessageTopic) -> Publisher:
        if topic.name not in self._publishers:
            qos = LATCHED if isinstance(topic, LatchedTopic) else HIGH_RATE
            publisher = self._node.create_publisher(topic.type_name, topic.name, qos)
            self._publishers[topic.name] = publisher
        return self._publishers[topic.name]

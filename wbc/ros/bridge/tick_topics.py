"""Publishes the topics of `wbc.topics`, which the log has as well."""

from __future__ import annotations

import numpy as np

from wbc.messages import message_type
from wbc.robot import Robot
from wbc.robot.packages import with_file_addresses
from wbc.ros.bridge.config import NodeConfig
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.joint_publisher import RATE_BOUNDS
from wbc.ros.node import Node
from wbc.ros.qos import HIGH_RATE, LATCHED
from wbc.ros.topics import Publisher
from wbc.runtime.rate_limiter import RateLimiter
from wbc.runtime.schema import Schema
from wbc.topics import BatchMaker, LatchedTopic, MessageTopic, StreamTopics

_JOINT_STATES, _DESCRIPTION = "joint_states", "robot_description"
_COUNT_RATE = 10.0  # Hz at which subscriptions are counted


class TickTopics:
    """Publishes ticks: `joint_states` at `update_rate`, all other topics at `state_rate`.

    Topics without subscriptions are not encoded.

    Args:
        node: node that publishes the topics; it gets the two parameters.
        config: configuration of the node's process.
    """

    def __init__(self, node: Node, config: NodeConfig) -> None:
        self._node = node
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
        self._topics = StreamTopics(config.robot, period=0.0)
        self._publishers: dict[str, Publisher] = {}
        self._subscribed: list[tuple[MessageTopic, Publisher]] = []
        self._count_limiter = RateLimiter(_COUNT_RATE)
        for topic in self._topics.topics:
            publisher = self._publisher(topic)
            if isinstance(topic, LatchedTopic):
                data = topic.data
                if config.mesh_files and topic.name == _DESCRIPTION:
                    data = _with_mesh_files(config.robot, data)
                publisher.publish(data)

    @property
    def max_rate(self) -> float:
        """The larger one of both rates, Hz."""
        return float(max(self._update_rate.value, self._state_rate.value))

    def _restart(self, _: float) -> None:
        """Publish the next tick on all topics, so that topics of equal rates have equal stamps."""
        self._update_limiter.restart(self._update_rate.value)
        self._state_limiter.restart(self._state_rate.value)

    def attach(self, schema: Schema) -> None:
        """Publish the quantities of a stream from now on."""
        if self._topics.attach(schema):
            self._subscribed = []
            self._count_limiter.restart(_COUNT_RATE)

    def publish(self, tick: StampedTick) -> None:
        """Publish a tick on the topics that are due."""
        update_due = self._update_limiter.is_due(tick.stamp)
        state_due = self._state_limiter.is_due(tick.stamp)
        if not (update_due or state_due):
            return
        topics = self._topics.topics_of(tick.record)
        if self._count_limiter.is_due(tick.stamp):
            self._subscribed = [
                (topic, publisher)
                for topic in topics
                if not isinstance(topic, LatchedTopic)
                and (publisher := self._publisher(topic)).get_subscription_count()
            ]
        due = [
            (topic, publisher)
            for topic, publisher in self._subscribed
            if (update_due if topic.name == _JOINT_STATES else state_due)
        ]
        if not due:
            return
        batch = self._batches.batch(tick.record, np.array([round(1e9 * tick.stamp)]))
        for topic, publisher in due:
            for _, data in topic.messages(batch):
                for message in data:
                    publisher.publish(message.tobytes())

    def _publisher(self, topic: MessageTopic) -> Publisher:
        if topic.name not in self._publishers:
            qos = LATCHED if isinstance(topic, LatchedTopic) else HIGH_RATE
            publisher = self._node.create_publisher(topic.type_name, topic.name, qos)
            self._publishers[topic.name] = publisher
        return self._publishers[topic.name]


def _with_mesh_files(robot: Robot, data: bytes) -> bytes:
    """Return a serialized description with the files of its meshes instead of packages."""
    message = message_type("std_msgs/msg/String").decode(data)
    message.data = with_file_addresses(message.data, robot.urdf_path, robot.package_dirs)
    return message.encode()

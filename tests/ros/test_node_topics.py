"""Topics of the robot's node that are not quantities of the tick."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from rostools import TIMEOUT, MessageCollector, node, unused_domain

import wbc
from wbc.ros import RosError
from wbc.ros.bridge.node_topics import TOPICS, NodeTopic, NodeTopics
from wbc.ros.qos import LATCHED

POINT = "geometry_msgs/msg/PointStamped"


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture
def two_nodes():
    domain = unused_domain()
    with node("robot", domain) as publishing, node("listener", domain) as listening:
        yield publishing, listening


def first_message(two_nodes, kind: str, topic: str):
    """Return the first message of a topic, while both nodes spin."""
    publishing, listening = two_nodes
    collector = MessageCollector(listening, kind, topic, LATCHED)

    def is_received() -> bool:
        publishing.spin_once(0.0)
        return bool(collector.messages)

    assert listening.spin_until(is_received, TIMEOUT)
    return collector.last


def test_topic_without_a_rate_is_published_once_for_late_subscribers(two_nodes, robot):
    NodeTopics(two_nodes[0], robot, TOPICS, lambda: None)
    corners = [
        (p.x, p.y)
        for p in first_message(two_nodes, "geometry_msgs/msg/Polygon", "footprint").points
    ]
    left, right = robot.soles
    x, y = np.array(corners).T
    assert np.ptp(x) == pytest.approx(2.0 * left.half_length, abs=0.03)
    assert np.ptp(y) > 2.0 * (left.half_width + right.half_width)
    assert y.max() == pytest.approx(-y.min(), abs=1e-3)


def test_topic_with_a_rate_is_filled_from_the_latest_tick(two_nodes, robot):
    class Tick:
        stamp = 12.5

    def fill(message, filled_robot, tick):
        assert filled_robot is robot
        message.point.x = tick.stamp

    NodeTopics(two_nodes[0], robot, (NodeTopic("mine", POINT, fill, rate=50.0),), Tick)
    message = first_message(two_nodes, POINT, "mine")
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 500_000_000)
    assert message.point.x == 12.5


def test_exception_in_fill_is_logged_and_does_not_stop_the_node(two_nodes, robot, caplog):
    def fail(message, robot, tick):
        raise ValueError("no data")

    with caplog.at_level(logging.ERROR, "wbc"):
        NodeTopics(two_nodes[0], robot, (NodeTopic("mine", POINT, fail),), lambda: None)
    assert "topic mine: ValueError: no data" in caplog.text


def test_fill_function_that_cannot_be_imported_is_refused():
    with pytest.raises(RosError, match="topic 'mine': another process cannot import"):
        NodeTopic("mine", POINT, lambda *_: None).check_importable()
    NodeTopic("mine", POINT, first_message).check_importable()
    with pytest.raises(RosError, match="must be positive"):
        NodeTopic("mine", POINT, first_message, rate=0.0)

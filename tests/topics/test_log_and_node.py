"""The log and the ROS 2 node have the same transforms and descriptions."""

import os
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from logtools import StreamedLog, random_tick, robot

from wbc.log import Log
from wbc.messages import message_type
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.bridge.tick_topics import TickTopics
from wbc.runtime.stream import TickReader

TOPICS = ("/tf", "/tf_static", "/robot_description", "/odom")


class RecordingNode:
    """A node without a network, whose topics all have a subscription."""

    def __init__(self):
        self.published = {}

    def declare_parameter(self, name, value, *_, **__):
        return SimpleNamespace(value=value, on_change=None)

    def create_publisher(self, msg_type, topic, _):
        decode = message_type(msg_type).decode
        messages = self.published.setdefault("/" + topic.lstrip("/"), [])
        return SimpleNamespace(
            publish=lambda data: messages.append(decode(data)), get_subscription_count=lambda: 1
        )


@pytest.fixture(scope="module")
def messages(tmp_path_factory):
    """Messages of the same ticks by topic: of the log, and of the node."""
    humanoid, rng = robot(), np.random.default_rng(2)
    path, node = tmp_path_factory.mktemp("same") / "run.mcap", RecordingNode()
    config = SimpleNamespace(robot=humanoid, update_rate=50.0, dt=0.02, mesh_files=False)
    topics = TickTopics(node, config)
    with StreamedLog(path, humanoid) as log:
        log.stream.begin_run()
        reader = TickReader()
        link, descriptor = log.stream.link()
        reader.on_message(replace(link, descriptor=os.dup(descriptor)))
        log.begin()
        for k in range(5):
            log.record(random_tick(humanoid, rng, 0.04 * k))
        records = reader.take(100)
    topics.attach(reader.schema)
    for tick in StampedTick.from_records(records):
        topics.publish(replace(tick, stamp=tick.time))
    logged = Log(path)
    return {name: (logged[name].messages(), node.published[name]) for name in TOPICS}


@pytest.mark.parametrize("topic", ["/tf_static", "/robot_description"])
def test_latched_messages_of_the_log_are_those_of_the_node(messages, topic):
    (logged,), (published,) = messages[topic]
    assert logged == published


@pytest.mark.parametrize("topic", ["/tf", "/odom"])
def test_poses_of_the_log_are_those_of_the_node(messages, topic):
    logged, published = messages[topic]
    assert len(logged) == 5
    assert logged == published


def test_the_transforms_connect_all_links_from_odom_on(messages):
    moving, fixed = messages["/tf"][0][0].transforms, messages["/tf_static"][0][0].transforms
    parents = {t.child_frame_id: t.header.frame_id for t in (*moving, *fixed)}
    assert len(parents) == len(moving) + len(fixed), "every frame has one parent"
    for frame in parents:
        while frame in parents:
            frame = parents[frame]
        assert frame in ("odom", "map", "world")

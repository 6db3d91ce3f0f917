"""The examples of ROS 2 are run as a user runs them."""

from __future__ import annotations

import pytest
from rostools import node, start_example, unused_domain

from wbc.messages import message_type
from wbc.ros.joint_publisher import JOINT_NAMES, walking_pattern

pytest.importorskip("cyclonedds")
pytest.importorskip("mujoco")

JointState = message_type("sensor_msgs/msg/JointState")


def test_example_prints_the_right_knee_for_any_order_of_the_joints():
    domain = unused_domain()
    listener = start_example(domain, "01_right_knee.py", "-n", "3")
    with node("joint_publisher", domain) as publishing:
        publisher = publishing.create_publisher(JointState.type_name, "joint_states")
        assert publishing.spin_until(lambda: publisher.get_subscription_count() > 0, 20.0)
        positions = dict(zip(JOINT_NAMES, walking_pattern(1.0), strict=True))
        backward = list(reversed(JOINT_NAMES))
        others = [name for name in JOINT_NAMES if name != "right_knee"]
        for names in (
            others,  # without the knee
            list(JOINT_NAMES),
            backward,
            [],
            ["left_knee", "right_knee"],
        ):
            publisher.publish(JointState(name=names, position=[positions[n] for n in names]))
        publisher.publish(JointState(name=["right_knee"], position=[]))
        publishing.spin_until(lambda: listener.poll() is not None, 10.0)
    out, error = listener.communicate(timeout=10.0)
    assert listener.returncode == 0, error
    first, *knees = out.splitlines()
    assert first.startswith("a message without right_knee; it has torso_yaw, ")
    angle = positions["right_knee"]
    assert knees == [f"right_knee: {angle:+.3f} rad = {angle * 57.29577951308232:+.1f}°"] * 3


def test_example_runs_a_walking_robot():
    done = start_example(unused_domain(), "02_walking_robot.py", "--duration", "0.5")
    out, error = done.communicate(timeout=60.0)
    assert done.returncode == 0, error
    assert "survived" in out

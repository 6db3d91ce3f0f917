"""Topics are exchanged with another implementation of DDS, Debian's Fast-DDS.

Its peer, `fastdds/echo.cpp`, is built with g++ and libfastrtps-dev. Where these are missing the
tests are skipped, unless WBC_REQUIRE_FASTDDS is set.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from rostools import ROOT, TIMEOUT, MessageCollector, environment, node

import wbc
from wbc.messages import message_type
from wbc.ros import QoSProfile
from wbc.ros.qos import LATCHED

pytest.importorskip("cyclonedds")
pytestmark = pytest.mark.slow

JointState = message_type("sensor_msgs/msg/JointState")
Text = message_type("std_msgs/msg/String")
Twist = message_type("geometry_msgs/msg/Twist")


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    compiler = shutil.which("g++")
    header = Path("/usr/include/fastdds/dds/domain/DomainParticipant.hpp")
    if compiler is None or not header.is_file():
        if os.environ.get("WBC_REQUIRE_FASTDDS"):
            pytest.fail("g++ or libfastrtps-dev is missing, and WBC_REQUIRE_FASTDDS is set")
        pytest.skip("needs g++ and libfastrtps-dev")
    made = tmp_path_factory.mktemp("fastdds") / "echo"
    source = ROOT / "tests" / "fastdds" / "echo.cpp"
    libraries = ("-lfastrtps", "-lfastcdr")
    subprocess.run([compiler, "-std=c++17", "-o", made, source, *libraries], check=True)
    return made


@pytest.fixture(scope="module")
def local_node(domain):
    with node("local", domain) as made:
        yield made


@pytest.fixture(scope="module")
def description(local_node):
    """Description that is published on a latched topic before the peer starts."""
    publisher = local_node.create_publisher(Text.type_name, "robot_description", LATCHED)
    text = wbc.load("simple_humanoid").urdf_path.read_text("utf-8")
    publisher.publish(Text(data=text))
    return text


@pytest.fixture(scope="module")
def peer(program, domain, description):
    process = subprocess.Popen(
        [program, str(domain)],
        env=environment(domain),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline().strip() == "ready"
    yield process
    process.communicate(timeout=10.0)
    assert process.returncode == 0


def wait_for_echo(local_node, publisher, received, probe):
    """Wait until a message is echoed, when both sides have discovered each other."""

    def connected():
        return publisher.get_subscription_count() and received.subscription.get_publisher_count()

    assert local_node.spin_until(connected, TIMEOUT)
    for _ in range(round(TIMEOUT / 0.25)):
        publisher.publish(probe)
        if local_node.spin_until(lambda: len(received) > 0, 0.25):
            break
    assert len(received) > 0


def test_joint_states_are_echoed_unchanged(peer, local_node):
    publisher = local_node.create_publisher(JointState.type_name, "joint_states")
    back = []
    probe = JointState().encode()

    def subscribe(data, _):
        if data[: len(probe)] != probe:  # it may arrive several times, and late
            back.append(data)

    local_node.create_raw_subscription(JointState.dds_name(), "joint_states_echo", subscribe)
    received = MessageCollector(
        local_node, JointState.type_name, "joint_states_echo", QoSProfile(depth=100)
    )
    wait_for_echo(local_node, publisher, received, JointState())
    rng = np.random.default_rng(0)
    sent = []
    for count in (0, 1, 15, 32):
        message = JointState(
            name=[f"joint_{i}" for i in range(count)],
            position=rng.normal(size=count),
            velocity=rng.normal(size=count),
            effort=rng.normal(size=count),
        )
        message.header.frame_id = "base_link"
        message.header.stamp.sec, message.header.stamp.nanosec = 1_700_000_000, 999_999_999
        sent.append(message.encode())
        publisher.publish(message)
    assert local_node.spin_until(lambda: len(back) == len(sent), TIMEOUT)
    assert back == [data + bytes(-len(data) % 4) for data in sent]
    assert local_node.spin_until(lambda: len(received.last.name) == 32, TIMEOUT)


def test_velocity_is_echoed_unchanged(peer, local_node):
    publisher = local_node.create_publisher(Twist.type_name, "cmd_vel")
    received = MessageCollector(local_node, Twist.type_name, "cmd_vel_echo")
    wait_for_echo(local_node, publisher, received, Twist())
    command = Twist()
    command.linear.x, command.linear.y, command.angular.z = 0.3, -0.1, 0.2
    publisher.publish(command)
    assert received.wait(lambda message: message != Twist()) == command


def test_latched_description_reaches_late_subscribers_on_both_sides(peer, local_node, description):
    """Each side subscribes after the other one has published."""
    local_node.spin(timeout_sec=1.0)
    received = MessageCollector(local_node, Text.type_name, "robot_description_echo", LATCHED)
    assert received.wait().data == description


def test_message_of_a_megabyte_is_echoed_unchanged(peer, local_node):
    publisher = local_node.create_publisher(JointState.type_name, "joint_states")
    received = MessageCollector(local_node, JointState.type_name, "joint_states_echo")
    wait_for_echo(local_node, publisher, received, JointState())
    numbers = np.arange(100_000.0)
    publisher.publish(JointState(position=numbers))
    message = received.wait(lambda m: m.position.size == numbers.size)
    assert np.array_equal(message.position, numbers)

"""Another implementation of DDS, Debian's Fast-DDS, reads what we write and writes what we read.

Its peer, `fastdds/echo.cpp`, is built here: it needs g++ and the package libfastrtps-dev. Where
those are missing the tests are skipped, unless WBC_REQUIRE_FASTDDS says that they must not be.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from rostools import PATIENCE, ROOT, Hearer, environment, node

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
def here(domain):
    with node("here", domain) as made:
        yield made


@pytest.fixture(scope="module")
def description(here):
    """Published, latched, before the peer is there."""
    publisher = here.create_publisher(Text.type_name, "robot_description", LATCHED)
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


def both_ways(here, publisher, heard, probe):
    """Wait until a message comes back: then either side has found the other's reader and writer."""

    def connected():
        return publisher.get_subscription_count() and heard.subscription.get_publisher_count()

    assert here.spin_until(connected, PATIENCE)
    for _ in range(round(PATIENCE / 0.25)):
        publisher.publish(probe)
        if here.spin_until(lambda: len(heard) > 0, 0.25):
            break
    assert len(heard) > 0


def test_joint_states_go_there_and_come_back_the_same(peer, here):
    publisher = here.create_publisher(JointState.type_name, "joint_states")
    back = []
    probe = JointState().encode()

    def hear(data, _):
        if data[: len(probe)] != probe:  # it may come several times, and late
            back.append(data)

    here.create_raw_subscription(JointState.dds_name(), "joint_states_echo", hear)
    heard = Hearer(here, JointState.type_name, "joint_states_echo", QoSProfile(depth=100))
    both_ways(here, publisher, heard, JointState())
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
    assert here.spin_until(lambda: len(back) == len(sent), PATIENCE)
    assert back == [data + bytes(-len(data) % 4) for data in sent]
    assert here.spin_until(lambda: len(heard.last.name) == 32, PATIENCE)


def test_a_velocity_goes_there_and_comes_back_the_same(peer, here):
    publisher = here.create_publisher(Twist.type_name, "cmd_vel")
    heard = Hearer(here, Twist.type_name, "cmd_vel_echo")
    both_ways(here, publisher, heard, Twist())
    command = Twist()
    command.linear.x, command.linear.y, command.angular.z = 0.3, -0.1, 0.2
    publisher.publish(command)
    assert heard.wait(lambda message: message != Twist()) == command


def test_a_latched_description_reaches_who_comes_late_both_ways(peer, here, description):
    """The peer came after it was published, and we listen after the peer has published it."""
    here.spin(timeout_sec=1.0)
    heard = Hearer(here, Text.type_name, "robot_description_echo", LATCHED)
    assert heard.wait().data == description


def test_a_megabyte_goes_there_and_comes_back(peer, here):
    publisher = here.create_publisher(JointState.type_name, "joint_states")
    heard = Hearer(here, JointState.type_name, "joint_states_echo")
    both_ways(here, publisher, heard, JointState())
    numbers = np.arange(100_000.0)
    publisher.publish(JointState(position=numbers))
    message = heard.wait(lambda m: m.position.size == numbers.size)
    assert np.array_equal(message.position, numbers)

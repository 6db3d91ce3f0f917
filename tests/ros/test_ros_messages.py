"""Messages on the wire, between two processes: every type, and what is no message."""

from __future__ import annotations

import os
import socket
import sys

import numpy as np
import pytest
from rostools import (
    PATIENCE,
    SHORT_LIVED,
    Hearer,
    Peer,
    configuration,
    new_domain,
    node,
    some_message,
    used_types,
)

from wbc.messages import message_type
from wbc.ros import QoSProfile, RosError
from wbc.ros.qos import LATCHED, ReliabilityPolicy

pytest.importorskip("cyclonedds")

#: As `ros2 topic info --verbose` and `ros2 service type` tell them in Jazzy.
KNOWN_HASHES = {
    "action_msgs/msg/GoalStatusArray": (
        "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e"
    ),
    "diagnostic_msgs/msg/DiagnosticArray": (
        "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"
    ),
    "geometry_msgs/msg/PointStamped": (
        "4c0296af86e01e562e9e0405d138a01537247580076c58ea38d7923ac1045897"
    ),
    "geometry_msgs/msg/Twist": "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    "geometry_msgs/msg/WrenchStamped": (
        "8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77"
    ),
    "nav_msgs/msg/Odometry": "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    "rcl_interfaces/msg/Log": "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac",
    "rcl_interfaces/msg/ParameterEvent": (
        "043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204"
    ),
    "rmw_dds_common/msg/ParticipantEntitiesInfo": (
        "91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"
    ),
    "rosgraph_msgs/msg/Clock": "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
    "tf2_msgs/msg/TFMessage": "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    "trajectory_msgs/msg/JointTrajectory": (
        "179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e"
    ),
    "std_msgs/msg/String": "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    "sensor_msgs/msg/JointState": (
        "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
    ),
}
#: Every fifth packet is lost; a participant tells about itself so often that others soon know it.
LOSSY = ",".join(
    (
        configuration("Internal/Test/XmitLossiness", "200"),
        configuration("Discovery/SPDPInterval", "200 ms"),
    )
)
KIND = "sensor_msgs/msg/JointState"
JointState = message_type(KIND)


@pytest.fixture(scope="module")
def echo():
    domain = new_domain()
    with Peer.of(domain, "echo"), node("tester", domain) as made:
        yield made


@pytest.mark.parametrize("name", KNOWN_HASHES)
def test_types_have_the_hashes_that_ros_gives_them(name):
    assert message_type(name).type_hash() == f"RIHS01_{KNOWN_HASHES[name]}"


def test_every_type_comes_back_from_another_process_as_it_was_sent(echo):
    """Bytes go out, are decoded and encoded there, and come back the same."""
    expected, heard, writers = {}, {}, []
    for seed, name in enumerate(used_types()):
        topic = name.replace("/", "_").lower()
        data = some_message(name, seed).encode()
        writers.append((echo.create_publisher(name, f"forth/{topic}"), data))
        expected[name] = data
        dds_name = message_type(name).dds_name()
        hear = lambda d, _, n=name: heard.setdefault(n, d)  # noqa: E731
        echo.create_raw_subscription(dds_name, f"back/{topic}", hear, LATCHED)
    assert echo.spin_until(lambda: all(w.get_subscription_count() for w, _ in writers), PATIENCE)
    for writer, data in writers:
        writer.publish(data)
    assert echo.spin_until(lambda: len(heard) == len(expected), PATIENCE), set(expected) - set(
        heard
    )
    for name, data in expected.items():
        # DDS fills messages up to whole words.
        assert heard[name] == data + bytes(-len(data) % 4), name


def test_a_large_message_arrives_whole(echo):
    heard = Hearer(echo, KIND, "back/sensor_msgs_msg_jointstate", LATCHED)
    publisher = echo.create_publisher(KIND, "forth/sensor_msgs_msg_jointstate")
    assert echo.spin_until(
        lambda: publisher.get_subscription_count() and heard.subscription.get_publisher_count(),
        PATIENCE,
    )
    numbers = np.arange(1_000_000.0)  # 8 MB
    publisher.publish(JointState(position=numbers))
    message = heard.wait(lambda m: len(m.position) == len(numbers))
    assert np.array_equal(message.position, numbers)


@pytest.fixture
def pair():
    """Two nodes that talk through the network although they are in one process."""
    domain = new_domain()
    with node("reader", domain) as reader, node("writer", domain) as writer:
        yield reader, writer


def spin(nodes, until, timeout=PATIENCE):
    one, *others = nodes

    def work():
        for other in others:
            other.spin_once(0.0)
        return until()

    return one.spin_until(work, timeout)


GOOD = JointState(name=["knee"], position=[0.5]).encode()
BAD = {
    "cut off": GOOD[:30],
    "without a body": GOOD[:4],
    "of another encoding": b"\x00\x07\x00\x00" + GOOD[4:],
    "with a length beyond its end": GOOD[:20] + b"\xff\xff\xff\x7f" + GOOD[24:],
    "of ones": GOOD[:4] + b"\xff" * 400,
    "longer": GOOD + b"more" * 1000,
    "at random": GOOD[:4] + os.urandom(200),
}


@pytest.fixture(scope="module")
def rogue():
    """A writer of the same topics and type name in another process, and a node that listens."""
    domain = new_domain()
    with Peer.of(domain, "rogue", JointState.dds_name()) as peer, node("good", domain) as made:
        yield peer, made


@pytest.mark.parametrize("what", BAD)
def test_what_is_no_message_is_skipped(rogue, what):
    peer, listener = rogue
    topic = what.replace(" ", "_")
    heard = Hearer(listener, KIND, topic)
    for data in (GOOD, BAD[what], GOOD):
        peer.tell(f"{topic} {data.hex()}")
    assert listener.spin_until(lambda: len(heard) >= 2, PATIENCE)
    listener.spin(timeout_sec=0.05)
    assert [m.position.tolist() for m in heard.messages] == [[0.5], [0.5]]


def test_a_message_of_another_type_is_not_published(pair):
    publisher = pair[1].create_publisher(KIND, "joint_states")
    with pytest.raises(RosError, match="carries sensor_msgs/msg/JointState"):
        publisher.publish(message_type("std_msgs/msg/String")())


def test_a_topic_of_another_type_is_not_heard(pair):
    reader, writer = pair
    heard = Hearer(reader, KIND, "joint_states")
    text = message_type("std_msgs/msg/String")
    writer.create_publisher(text.type_name, "joint_states").publish(text(data="hello"))
    right = writer.create_publisher(KIND, "joint_states")
    assert spin(pair, lambda: right.get_subscription_count())
    right.publish(JointState(name=["knee"], position=[0.5]))
    assert spin(pair, lambda: len(heard) > 0)
    assert len(heard) == 1


def test_what_a_network_loses_is_sent_again():
    """Every fifth packet of the sender is lost; nothing is missing, nothing comes twice."""
    domain = new_domain()
    sender = Peer.of(domain, "count", "400", "100", "1000", configuration=LOSSY)
    with sender, node("receiver", domain) as receiver:
        heard = Hearer(receiver, KIND, "joint_states", QoSProfile(depth=1000))
        assert receiver.spin_until(lambda: len(heard) >= 100, PATIENCE), len(heard)
        receiver.spin(timeout_sec=0.2)
        assert [m.position[0] for m in heard.messages] == list(range(100))


def packets(capture):
    """Where each captured packet went (address, port), and its bytes: pcap of IPv4 and UDP."""
    at = 24
    while at + 16 <= len(capture):
        size = int.from_bytes(capture[at + 8 : at + 12], sys.byteorder)
        packet = capture[at + 16 : at + 16 + size]
        if len(packet) < size:  # a file that is still written ends anywhere
            break
        head = 4 * (packet[0] & 15)
        port = int.from_bytes(packet[head + 2 : head + 4], "big")
        yield (socket.inet_ntoa(packet[16:20]), port), packet[head + 8 :]
        at += 16 + size


def test_what_a_network_delivers_twice_comes_once(tmp_path):
    """Every packet that the sender has sent is sent again, some time later."""
    domain, capture = new_domain(), tmp_path / "sent.pcap"
    kept = configuration("Tracing/PacketCaptureFile", str(capture))
    sender = Peer.of(domain, "count", "400", "50", "1000", configuration=kept)
    with sender, node("receiver", domain) as receiver:
        heard = Hearer(receiver, KIND, "joint_states", QoSProfile(depth=1000))
        assert receiver.spin_until(lambda: len(heard) >= 50, PATIENCE), len(heard)
        again = list(packets(capture.read_bytes()))
        assert sum(b"joint_31" in data for _, data in again) > 25  # the last ones may be buffered
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as network:
            for where, data in again:
                network.sendto(data, where)
        receiver.spin(timeout_sec=0.3)
        assert [m.position[0] for m in heard.messages] == list(range(50))


def test_without_reliability_what_is_lost_stays_lost_and_the_rest_comes_in_order():
    domain = new_domain()
    sender = Peer.of(domain, "count", "400", "1000000", "1000", configuration=LOSSY)
    with sender, node("receiver", domain) as receiver:
        heard = Hearer(
            receiver, KIND, "joint_states", QoSProfile(1000, ReliabilityPolicy.BEST_EFFORT)
        )
        assert receiver.spin_until(lambda: len(heard) >= 100, PATIENCE), len(heard)
        numbers = np.array([m.position[0] for m in heard.messages])
        assert (np.diff(numbers) > 0).all()
        assert numbers[-1] - numbers[0] > len(numbers) - 1


def test_the_latest_of_a_latched_topic_comes_late_and_once():
    domain = new_domain()
    with Peer.of(domain, "latch", "old", "new"), node("late", domain) as late:
        latched = LATCHED
        heard = Hearer(late, "std_msgs/msg/String", "robot_description", latched)
        assert heard.wait().data == "new"
        late.spin(timeout_sec=0.3)
        assert len(heard) == 1


def test_a_peer_that_dies_is_forgotten():
    domain = new_domain()
    mortal = Peer.of(domain, "count", "100", "1000000", configuration=SHORT_LIVED)
    with mortal, node("here", domain) as here:
        heard = Hearer(here, KIND, "joint_states")
        heard.wait()
        mortal.kill()
        assert here.spin_until(lambda: heard.subscription.get_publisher_count() == 0, PATIENCE)

"""Messages between two processes: every type, invalid data, lossy networks, dead peers."""

from __future__ import annotations

import os
import socket
import sys

import numpy as np
import pytest
from rostools import (
    SHORT_LEASE,
    TIMEOUT,
    MessageCollector,
    PeerProcess,
    configuration,
    node,
    random_message,
    unused_domain,
    used_types,
)

from wbc.messages import message_type
from wbc.ros import QoSProfile, RosError
from wbc.ros.qos import LATCHED, ReliabilityPolicy

pytest.importorskip("cyclonedds")

#: Printed by `ros2 topic info --verbose` in Jazzy.
KNOWN_HASHES = {
    "control_msgs/action/FollowJointTrajectory_SendGoal_Request": (
        "179c93691f1f6d1d115881ff88c3917b7cc6eac2ba4bf56766cc7c4389e19ef1"
    ),
    "control_msgs/action/FollowJointTrajectory_Feedback": (
        "3fd0aaecf71725121ae1ff7f01098a5e0da581e672be18a6b2c286cb43d96b49"
    ),
    "nav2_msgs/action/NavigateToPose_SendGoal_Request": (
        "e9381f2acfe9fa8c4838a277d0cde28a93c483564827b9f13496b9c2092e4f09"
    ),
    "nav2_msgs/action/NavigateToPose_GetResult_Response": (
        "c59f178c377de5318919c00bdbf7884cb3b185acfdffceba6c9f161e0aa3cc81"
    ),
    "nav2_msgs/action/NavigateToPose_FeedbackMessage": (
        "9d1f6fa2eb975ce733b419ac2e97b134d8ff92b6478b6559feed9a50bdfd82b3"
    ),
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
#: Every fifth packet is lost; a short discovery interval makes up for lost announcements.
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
    domain = unused_domain()
    with PeerProcess.start_peer(domain, "echo"), node("tester", domain) as made:
        yield made


@pytest.mark.parametrize("name", KNOWN_HASHES)
def test_type_hashes_equal_those_of_ros(name):
    assert message_type(name).type_hash() == f"RIHS01_{KNOWN_HASHES[name]}"


def test_every_type_is_echoed_by_another_process_unchanged(echo):
    """The peer decodes and encodes the messages."""
    expected, received, writers = {}, {}, []
    for seed, name in enumerate(used_types()):
        topic = name.replace("/", "_").lower()
        data = random_message(name, seed).encode()
        writers.append((echo.create_publisher(name, f"forth/{topic}"), data))
        expected[name] = data
        dds_name = message_type(name).dds_name()
        subscribe = lambda d, _, n=name: received.setdefault(n, d)  # noqa: E731
        echo.create_raw_subscription(dds_name, f"back/{topic}", subscribe, LATCHED)
    assert echo.spin_until(lambda: all(w.get_subscription_count() for w, _ in writers), TIMEOUT)
    for writer, data in writers:
        writer.publish(data)
    assert echo.spin_until(lambda: len(received) == len(expected), TIMEOUT), set(expected) - set(
        received
    )
    for name, data in expected.items():
        # DDS pads messages to a multiple of four bytes.
        assert received[name] == data + bytes(-len(data) % 4), name


def test_large_message_arrives_complete(echo):
    received = MessageCollector(echo, KIND, "back/sensor_msgs_msg_jointstate", LATCHED)
    publisher = echo.create_publisher(KIND, "forth/sensor_msgs_msg_jointstate")
    assert echo.spin_until(
        lambda: publisher.get_subscription_count() and received.subscription.get_publisher_count(),
        TIMEOUT,
    )
    numbers = np.arange(1_000_000.0)  # 8 MB
    publisher.publish(JointState(position=numbers))
    message = received.wait(lambda m: len(m.position) == len(numbers))
    assert np.array_equal(message.position, numbers)


@pytest.fixture
def pair():
    """Two nodes in one process, which communicate through the network."""
    domain = unused_domain()
    with node("reader", domain) as reader, node("writer", domain) as writer:
        yield reader, writer


def spin(nodes, until, timeout=TIMEOUT):
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
def raw_peer():
    """A peer that publishes arbitrary bytes with a valid type name, and a node."""
    domain = unused_domain()
    with (
        PeerProcess.start_peer(domain, "publish_raw", JointState.dds_name()) as peer,
        node("good", domain) as made,
    ):
        yield peer, made


@pytest.mark.parametrize("what", BAD)
def test_invalid_message_is_skipped(raw_peer, what):
    peer, listener = raw_peer
    topic = what.replace(" ", "_")
    received = MessageCollector(listener, KIND, topic)
    for data in (GOOD, BAD[what], GOOD):
        peer.write_line(f"{topic} {data.hex()}")
    assert listener.spin_until(lambda: len(received) >= 2, TIMEOUT)
    listener.spin(timeout_sec=0.05)
    assert [m.position.tolist() for m in received.messages] == [[0.5], [0.5]]


def test_message_of_another_type_is_refused(pair):
    publisher = pair[1].create_publisher(KIND, "joint_states")
    with pytest.raises(RosError, match="carries sensor_msgs/msg/JointState"):
        publisher.publish(message_type("std_msgs/msg/String")())


def test_publisher_of_another_type_is_not_matched(pair):
    reader, writer = pair
    received = MessageCollector(reader, KIND, "joint_states")
    text = message_type("std_msgs/msg/String")
    writer.create_publisher(text.type_name, "joint_states").publish(text(data="hello"))
    right = writer.create_publisher(KIND, "joint_states")
    assert spin(pair, lambda: right.get_subscription_count())
    right.publish(JointState(name=["knee"], position=[0.5]))
    assert spin(pair, lambda: len(received) > 0)
    assert len(received) == 1


def test_lost_packets_are_sent_again():
    """Every fifth packet of the sender is lost; each message arrives once."""
    domain = unused_domain()
    sender = PeerProcess.start_peer(
        domain, "publish_numbers", "400", "100", "1000", configuration=LOSSY
    )
    with sender, node("receiver", domain) as receiver:
        received = MessageCollector(receiver, KIND, "joint_states", QoSProfile(depth=1000))
        assert receiver.spin_until(lambda: len(received) >= 100, TIMEOUT), len(received)
        receiver.spin(timeout_sec=0.2)
        assert [m.position[0] for m in received.messages] == list(range(100))


def packets(capture):
    """Iterate over destination (address, port) and payload of the UDP packets of a pcap file."""
    at = 24
    while at + 16 <= len(capture):
        size = int.from_bytes(capture[at + 8 : at + 12], sys.byteorder)
        packet = capture[at + 16 : at + 16 + size]
        if len(packet) < size:  # the file is still being written
            break
        head = 4 * (packet[0] & 15)
        port = int.from_bytes(packet[head + 2 : head + 4], "big")
        yield (socket.inet_ntoa(packet[16:20]), port), packet[head + 8 :]
        at += 16 + size


def test_duplicate_packets_are_delivered_once(tmp_path):
    """All packets of the sender are captured and sent once more."""
    domain, capture = unused_domain(), tmp_path / "sent.pcap"
    kept = configuration("Tracing/PacketCaptureFile", str(capture))
    sender = PeerProcess.start_peer(
        domain, "publish_numbers", "400", "50", "1000", configuration=kept
    )
    with sender, node("receiver", domain) as receiver:
        received = MessageCollector(receiver, KIND, "joint_states", QoSProfile(depth=1000))
        assert receiver.spin_until(lambda: len(received) >= 50, TIMEOUT), len(received)
        again = list(packets(capture.read_bytes()))
        assert sum(b"joint_31" in data for _, data in again) > 25  # the last ones may be buffered
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as network:
            for where, data in again:
                network.sendto(data, where)
        receiver.spin(timeout_sec=0.3)
        assert [m.position[0] for m in received.messages] == list(range(50))


def test_best_effort_loses_messages_but_keeps_their_order():
    domain = unused_domain()
    sender = PeerProcess.start_peer(
        domain, "publish_numbers", "400", "1000000", "1000", configuration=LOSSY
    )
    with sender, node("receiver", domain) as receiver:
        received = MessageCollector(
            receiver, KIND, "joint_states", QoSProfile(1000, ReliabilityPolicy.BEST_EFFORT)
        )
        assert receiver.spin_until(lambda: len(received) >= 100, TIMEOUT), len(received)
        numbers = np.array([m.position[0] for m in received.messages])
        assert (np.diff(numbers) > 0).all()
        assert numbers[-1] - numbers[0] > len(numbers) - 1


def test_late_subscriber_gets_the_latest_latched_message_once():
    domain = unused_domain()
    with (
        PeerProcess.start_peer(domain, "publish_latched", "old", "new"),
        node("late", domain) as late,
    ):
        latched = LATCHED
        received = MessageCollector(late, "std_msgs/msg/String", "robot_description", latched)
        assert received.wait().data == "new"
        late.spin(timeout_sec=0.3)
        assert len(received) == 1


def test_dead_peer_is_removed():
    domain = unused_domain()
    sender = PeerProcess.start_peer(
        domain, "publish_numbers", "100", "1000000", configuration=SHORT_LEASE
    )
    with sender, node("local", domain) as local_node:
        received = MessageCollector(local_node, KIND, "joint_states")
        received.wait()
        sender.kill()
        assert local_node.spin_until(
            lambda: received.subscription.get_publisher_count() == 0, TIMEOUT
        )

"""Name, types, endpoints and quality of service of a node are discovered as in ROS 2."""

from __future__ import annotations

import contextlib
import math
import re
import signal
import threading
import time

import numpy as np
import pytest
from rostools import TIMEOUT, MessageCollector, PeerProcess, environment, node, unused_domain

import wbc
from wbc.cli import main
from wbc.ros import QoSProfile
from wbc.ros.discovery import DiscoveryFormat, NodeEntities
from wbc.ros.joint_publisher import JOINT_NAMES, walking_pattern
from wbc.ros.qos import LATCHED

pytest.importorskip("cyclonedds")

#: Printed by `ros2 topic info --verbose` in Jazzy for the topic of joint_state_broadcaster.
JOINT_STATE_HASH = "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"


@pytest.fixture(scope="module")
def publisher(domain):
    with PeerProcess.start_wbc(domain, "ros2", "joint-publisher", "--rate", "100") as peer:
        assert "started at 100.0 Hz" in peer.first_line
        yield peer


@pytest.fixture(scope="module")
def observer(domain):
    with node("observer", domain) as made:
        yield made


@pytest.fixture(scope="module")
def graph(publisher, observer):
    return observer.graph


@pytest.fixture(scope="module")
def snapshot(graph):
    def complete(state):
        named = all(e.node for e in state.endpoints)
        return len(state.services()) >= 6 and len(state.topics()) >= 4 and named

    state = graph.wait_for(complete, TIMEOUT)
    assert state is not None, graph.snapshot()
    return state


def raw_endpoints(observer):
    """Return all participants, and the publications that Cyclone DDS discovers by DDS name."""
    from cyclonedds.builtin import (
        BuiltinDataReader,
        BuiltinTopicDcpsParticipant,
        BuiltinTopicDcpsPublication,
    )

    dds = observer.participant.dds
    participants = BuiltinDataReader(dds, BuiltinTopicDcpsParticipant).read(100)
    publications = BuiltinDataReader(dds, BuiltinTopicDcpsPublication).read(1000)
    return participants, {p.topic_name: p for p in publications}


def test_node_name_is_in_the_graph(snapshot):
    assert snapshot.nodes == ("/joint_publisher",)


def test_topics_have_their_types(snapshot):
    types = {name: topic.types for name, topic in snapshot.topics().items()}
    assert types["/joint_states"] == ["sensor_msgs/msg/JointState"]
    assert types["/robot_description"] == ["std_msgs/msg/String"]
    assert types["/parameter_events"] == ["rcl_interfaces/msg/ParameterEvent"]


def test_every_endpoint_belongs_to_the_node(snapshot):
    assert {e.node for e in snapshot.endpoints} == {"/joint_publisher"}


def test_services_have_their_types(snapshot):
    services = snapshot.services()
    name = "/joint_publisher/set_parameters_atomically"
    assert services[name] == "rcl_interfaces/srv/SetParametersAtomically"


def test_participant_announces_its_enclave(snapshot, observer):
    from cyclonedds.core import Policy

    participants, _ = raw_endpoints(observer)
    assert participants
    assert {p.qos[Policy.Userdata].data for p in participants} == {b"enclave=/;"}


def test_writer_announces_the_type_hash_of_ros(snapshot, observer):
    from cyclonedds.core import Policy

    _, publications = raw_endpoints(observer)
    joint_states = publications["rt/joint_states"]
    assert joint_states.type_name == "sensor_msgs::msg::dds_::JointState_"
    assert joint_states.qos[Policy.Userdata].data.decode() == f"typehash={JOINT_STATE_HASH};"


def test_quality_of_service_equals_that_of_rmw_cyclonedds(snapshot, observer):
    from cyclonedds.core import Policy

    _, publications = raw_endpoints(observer)
    qos = publications["rt/joint_states"].qos
    assert qos[Policy.Reliability] == Policy.Reliability.Reliable((1 << 63) - 1)
    assert qos[Policy.Durability] == Policy.Durability.Volatile
    assert qos[Policy.History] == Policy.History.KeepLast(10)
    assert qos[Policy.DataRepresentation].use_cdrv0_representation
    assert not qos[Policy.DataRepresentation].use_xcdrv2_representation
    assert not qos[Policy.WriterDataLifecycle].autodispose
    latched = publications["rt/robot_description"].qos
    assert latched[Policy.Durability] == Policy.Durability.TransientLocal
    assert latched[Policy.History] == Policy.History.KeepLast(1)
    assert latched[Policy.DurabilityService].history == Policy.History.KeepLast(1)
    rosout = publications["rt/rosout"].qos
    assert rosout[Policy.Durability] == Policy.Durability.TransientLocal
    assert rosout[Policy.History] == Policy.History.KeepLast(1000)
    assert rosout[Policy.Lifespan] == Policy.Lifespan(10_000_000_000)
    service = publications["rr/joint_publisher/get_parametersReply"].qos
    assert service[Policy.History] == Policy.History.KeepLast(1000)


def test_reader_and_writer_of_a_service_carry_the_same_id(snapshot):
    ends = [e for e in snapshot.endpoints if e.topic == "/joint_publisher/get_parameters"]
    assert len(ends) == 2
    (identity,) = {e.user_data["serviceid"] for e in ends}
    assert re.fullmatch(r"[0-9a-f]{1,2}(\.[0-9a-f]{1,2}){15}", identity)
    assert all(re.fullmatch(r"RIHS01_[0-9a-f]{64}", e.type_hash) for e in ends)


def test_joint_publisher_has_the_joints_and_the_pattern_of_the_source_chapter(publisher, observer):
    received = MessageCollector(
        observer, "sensor_msgs/msg/JointState", "joint_states", QoSProfile(depth=1000)
    )
    received.wait(lambda _: len(received) >= 20)
    assert tuple(received.last.name) == JOINT_NAMES
    assert len(JOINT_NAMES) == 15
    assert received.last.header.frame_id == "base_link"
    assert received.last.velocity.size == received.last.effort.size == 0
    # The phase advances by the timer's period, which the program of the chapter omits.
    hips = [m.position[JOINT_NAMES.index("right_hip_pitch")] for m in received.messages]
    steps = np.diff(np.unwrap(np.arcsin(np.clip(np.array(hips) / 0.3, -1.0, 1.0))))
    rising = steps[np.abs(np.abs(steps) - 0.01) < 1e-6]
    assert rising.size > 0.7 * steps.size


def test_walking_pattern_equals_that_of_the_source_chapter():
    at = dict(zip(JOINT_NAMES, walking_pattern(math.pi / 2), strict=True))
    assert at["right_hip_pitch"] == pytest.approx(0.3)
    assert at["right_knee"] == pytest.approx(0.5)
    assert at["right_ankle_pitch"] == pytest.approx(-0.3)
    assert at["left_hip_pitch"] == pytest.approx(-0.3)
    assert at["left_knee"] == 0.0
    assert at["right_shoulder_pitch"] == pytest.approx(-0.2)
    assert at["left_elbow"] == at["right_elbow"] == 0.1
    assert at["torso_yaw"] == pytest.approx(0.0, abs=1e-12)


def test_late_subscriber_gets_a_description_that_has_the_published_joints(publisher, observer):
    received = MessageCollector(observer, "std_msgs/msg/String", "robot_description", LATCHED)
    text = received.wait().data
    robot = wbc.load("simple_humanoid")
    assert text == robot.urdf_path.read_text("utf-8")
    assert set(JOINT_NAMES) <= set(robot.joint_names)


@pytest.fixture
def environment_of_domain(domain, monkeypatch):
    for key in ("CYCLONEDDS_URI", "ROS_LOCALHOST_ONLY", "ROS_AUTOMATIC_DISCOVERY_RANGE"):
        monkeypatch.delenv(key, raising=False)
    monkeypatch.setenv("ROS_DOMAIN_ID", environment(domain)["ROS_DOMAIN_ID"])


@pytest.fixture
def command(publisher, environment_of_domain, capsys):
    def run(*arguments):
        code = main(["ros2", *arguments])
        taken = capsys.readouterr()
        return code, taken.out, taken.err

    return run


def test_nodes_topics_and_services_are_listed(command):
    code, nodes, _ = command("node", "list")
    assert code == 0
    assert "/joint_publisher" in nodes.splitlines()
    _, topics, _ = command("topic", "list")
    assert "/joint_states [sensor_msgs/msg/JointState]" in topics.splitlines()
    _, services, _ = command("service", "list")
    assert "/joint_publisher/get_parameters [rcl_interfaces/srv/GetParameters]" in services


def test_echo_prints_messages_and_fields(command):
    code, text, _ = command("topic", "echo", "/joint_states", "-n", "2")
    assert code == 0
    assert text.count("\n---\n") == 2
    assert "name:\n- torso_yaw\n- right_hip_pitch\n" in text
    _, one, _ = command("topic", "echo", "joint_states", "-n", "1", "--field", "header.frame_id")
    assert one == "base_link\n---\n"
    _, latched, _ = command("topic", "echo", "/robot_description", "-n", "1")
    assert '<robot name="simple_humanoid">' in latched


def test_hz_measures_the_rate(command):
    code, text, _ = command("topic", "hz", "/joint_states", "-n", "1")
    assert code == 0
    assert re.match(r"average rate: \d+\.\d+ Hz +min: ", text)


def test_info_prints_node_type_hash_and_quality_of_service(command):
    code, text, _ = command("topic", "info", "/joint_states")
    assert code == 0
    assert "publishers: 1\n  /joint_publisher\n" in text
    assert JOINT_STATE_HASH in text
    assert "reliable, volatile, keep last 10" in text


def test_node_info_prints_topics_and_services(command):
    code, text, _ = command("node", "info", "joint_publisher")
    assert code == 0
    assert "  Publishers:\n    /joint_states: sensor_msgs/msg/JointState\n" in text
    assert "    /joint_publisher/get_parameters: rcl_interfaces/srv/GetParameters\n" in text
    code, _, error = command("node", "info", "/joint_publishers")
    assert (code, "did you mean '/joint_publisher'?" in error) == (2, True)


def test_parameters_are_listed_read_and_set(command):
    assert command("param", "list")[1] == "/joint_publisher:\n  update_rate\n"
    assert command("param", "get", "joint_publisher", "update_rate")[1] == "100.0\n"
    code, text, _ = command("param", "set", "/joint_publisher", "update_rate", "900")
    assert code == 1
    assert "out of its range" in text
    assert command("param", "set", "/joint_publisher", "update_rate", "100")[:2] == (0, "set\n")
    assert "no parameter 'rate'" in command("param", "get", "joint_publisher", "rate")[2]


def test_error_for_an_unknown_topic_suggests_a_similar_one(command):
    code, _, error = command("topic", "echo", "/joint_state", "--wait", "0.3")
    assert code == 2
    assert "did you mean '/joint_states'?" in error


def test_error_for_an_unknown_field_names_it(command):
    code, _, error = command("topic", "echo", "/joint_states", "-n", "1", "--field", "positions[2]")
    assert code == 2
    assert "positions" in error


def test_rate_out_of_range_is_refused(environment_of_domain, capsys):
    assert main(["ros2", "joint-publisher", "--rate", "900"]) == 2
    assert "1 to 500" in capsys.readouterr().err


def test_node_that_leaves_disappears_from_the_graph_at_once(observer, graph, domain):
    with node("guest", domain):
        assert graph.wait_for(lambda snapshot: "/guest" in snapshot.nodes, TIMEOUT)
    # This is well before the 5 s after which a silent participant counts as dead.
    start = time.monotonic()
    assert graph.wait_for(lambda snapshot: "/guest" not in snapshot.nodes, 4.0), (
        time.monotonic() - start
    )


def test_late_observer_discovers_all_nodes():
    domain = unused_domain()
    with contextlib.ExitStack() as stack:
        observer = stack.enter_context(node("observer", domain))
        others = [stack.enter_context(node(f"other_{i}", domain)) for i in range(4)]
        for other in others:
            other.create_publisher("std_msgs/msg/String", "chatter")
        graph = observer.graph
        time.sleep(0.5)  # all have announced themselves, and nobody has read it
        names = [other.fully_qualified_name for other in others]

        def all_known(snapshot):
            chatter = snapshot.topics().get("/chatter")
            owners = sorted(e.node for e in chatter.publishers) if chatter else []
            return list(snapshot.nodes) == owners == names

        assert graph.wait_for(all_known, TIMEOUT), graph.snapshot()


def test_settle_waits_for_a_process_that_has_not_announced_its_nodes(publisher, snapshot, domain):
    """A stopped process is discovered, but announces its nodes only after it continues."""
    process = publisher.process
    with node("late", domain) as late:
        process.send_signal(signal.SIGSTOP)
        threading.Timer(0.8, process.send_signal, (signal.SIGCONT,)).start()
        state = late.graph.settle(max_sec=TIMEOUT)
    assert "/joint_publisher" in state.nodes
    assert all(e.node for e in state.endpoints)


def test_spin_until_returns_when_the_condition_was_true_once():
    results = iter([False, True, False, False])
    with node("waiting", unused_domain()) as waiting:
        assert waiting.spin_until(lambda: next(results), TIMEOUT)
        assert list(results) == [False, False]


def test_wait_for_returns_the_snapshot_that_fulfils_the_condition(observer, graph):
    snapshots = []

    def third(state):
        snapshots.append(state)
        return len(snapshots) == 3

    assert graph.wait_for(third, TIMEOUT) is snapshots[2]
    assert len(snapshots) == 3
    assert graph.wait_for(lambda _: False, 0.1) is None


def test_nodes_discover_each_other_in_the_format_of_humble(monkeypatch):
    monkeypatch.setenv("ROS_DISTRO", "humble")
    domain = unused_domain()
    with node("observer", domain) as first, node("talker", domain) as second:
        second.create_publisher("std_msgs/msg/String", "chatter")

        def is_announced(snapshot):
            return [e.node for e in snapshot.topic("/chatter").publishers] == ["/talker"]

        assert first.graph.wait_for(is_announced, TIMEOUT), first.graph.snapshot()


@pytest.mark.parametrize(("distribution", "size"), [("humble", 24), ("jazzy", 16), ("", 16)])
def test_discovery_message_has_the_format_of_the_distribution(distribution, size):
    typesys = pytest.importorskip("rosbags.typesys")
    form = DiscoveryFormat.from_environment({"ROS_DISTRO": distribution})
    assert form.gid_size == size
    node_entry = NodeEntities("/", "legs", (bytes(range(16)),), (bytes(range(1, 17)), bytes(16)))
    data = form.encode(bytes(range(16, 32)), (node_entry, NodeEntities("/a", "x")))
    release = typesys.Stores.ROS2_HUMBLE if size == 24 else typesys.Stores.ROS2_JAZZY
    store = typesys.get_typestore(release)
    kind = "rmw_dds_common/msg/ParticipantEntitiesInfo"
    message = store.deserialize_cdr(data, kind)
    assert bytes(message.gid.data)[:16] == bytes(range(16, 32))
    assert message.node_entities_info_seq[0].node_name == "legs"
    assert bytes(store.serialize_cdr(message, kind)) == data
    assert form.decode(data)[1][0] == node_entry


@pytest.mark.parametrize("side", ["writer", "reader"])
def test_matched_endpoints_are_counted_although_one_comes_while_they_are(domain, monkeypatch, side):
    with node("counting", domain) as one:
        publisher = one.create_publisher("std_msgs/msg/Bool", "counted")
        subscription = one.create_subscription("std_msgs/msg/Bool", "counted", lambda _: None)
        assert one.spin_until(publisher.get_subscription_count, TIMEOUT)
        endpoint = publisher.writer if side == "writer" else subscription.reader
        name = "get_matched_" + ("subscriptions" if side == "writer" else "publications")
        read, failures = getattr(endpoint.dds, name), [IndexError("invalid index")]

        def read_at_the_second_time() -> list[int]:
            if failures:
                raise failures.pop()
            return read()

        monkeypatch.setattr(endpoint.dds, name, read_at_the_second_time)
        assert len(endpoint.matched) == 1

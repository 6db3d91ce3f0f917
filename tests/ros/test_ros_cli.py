"""The verbs of `wbc ros2` that act on other nodes."""

from __future__ import annotations

import pytest
from rostools import TIMEOUT, MessageCollector, PeerProcess, node, unused_domain

from wbc.cli import main
from wbc.messages import MessageError, message_type
from wbc.ros.message_yaml import from_yaml

pytest.importorskip("cyclonedds")
pytest.importorskip("yaml")


@pytest.fixture(scope="module")
def domain():
    return unused_domain()


@pytest.fixture(scope="module", autouse=True)
def peer(domain):
    with PeerProcess.start_peer(domain, "serve"):
        yield


@pytest.fixture
def command(domain, capsys, monkeypatch):
    for key in ("CYCLONEDDS_URI", "ROS_LOCALHOST_ONLY", "ROS_AUTOMATIC_DISCOVERY_RANGE"):
        monkeypatch.delenv(key, raising=False)

    def run(*arguments):
        code = main(["ros2", *arguments, "--domain", str(domain)])
        taken = capsys.readouterr()
        return code, taken.out, taken.err

    return run


def test_service_is_called_with_a_request_in_yaml(command):
    code, text, _ = command("service", "call", "switch", "std_srvs/srv/SetBool", "{data: true}")
    assert code == 0
    assert text.startswith("success: true\nmessage: called ")


def test_call_of_a_missing_service_says_that_there_is_none(command):
    missing = ("service", "call", "none", "std_srvs/srv/SetBool", "--wait", "0.3")
    code, _, error = command(*missing)
    assert code == 2
    assert "there is no server for /none" in error


def test_node_info_prints_every_type_of_a_topic(command, domain):
    with node("driven", domain) as made:
        for kind in ("Twist", "TwistStamped"):
            made.create_subscription(f"geometry_msgs/msg/{kind}", "cmd_vel", print)
        code, text, _ = command("node", "info", "/driven")
    assert code == 0
    assert "/cmd_vel: geometry_msgs/msg/Twist, geometry_msgs/msg/TwistStamped\n" in text


def test_goal_is_sent_and_its_feedback_and_result_are_printed(command):
    kind = "nav2_msgs/action/NavigateToPose"
    goal = "{pose: {pose: {position: {x: 5.0}}}}"
    code, text, _ = command("action", "send_goal", "walk", kind, goal, "--feedback")
    assert code == 0
    assert "distance_remaining: 5.0" in text
    assert "succeeded\nerror_code: 0\nerror_msg: arrived" in text
    refused = "{pose: {pose: {position: {x: -1.0}}}}"
    assert command("action", "send_goal", "walk", kind, refused)[:2] == (
        1,
        "the goal was rejected\n",
    )
    assert command("action", "list")[1] == f"/walk [{kind}]\n"


def test_topic_is_published_a_number_of_times(command, domain):
    with node("listener", domain) as listener:
        received = MessageCollector(listener, "geometry_msgs/msg/Twist", "cmd_vel")
        once = ("topic", "pub", "/cmd_vel", "geometry_msgs/msg/Twist", "{linear: {x: 0.25}}")
        code, text, _ = command(*once, "-t", "2", "-r", "50")
        assert (code, text) == (0, "published 2 messages\n")
        assert listener.spin_until(lambda: len(received) == 2, TIMEOUT)
        assert received.last.linear.x == 0.25
    code, _, error = command(*once, "-1", "--wait", "0.3")
    assert code == 2
    assert "nobody subscribes to '/cmd_vel'" in error


def test_message_is_made_from_yaml():
    path = from_yaml(
        message_type("nav_msgs/msg/Path"),
        "{header: {stamp: now}, poses: [{pose: {position: {x: 1}}}, {}]}",
    )
    assert path.header.stamp.sec > 0
    assert [pose.pose.position.x for pose in path.poses] == [1.0, 0.0]
    for text, reason in (
        ("{x: }}", "is not YAML"),
        ("{speed: 1.0}", "no field 'speed'"),
        ("0.2", "is given by its fields"),
    ):
        with pytest.raises(MessageError, match=reason):
            from_yaml(message_type("geometry_msgs/msg/Twist"), text)

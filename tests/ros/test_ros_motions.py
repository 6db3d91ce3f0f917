"""Motions that another process requests from the robot's node."""

from __future__ import annotations

import numpy as np
import pytest
from rostools import SHORT_LEASE, TIMEOUT, MessageCollector, PeerProcess, start_example

import wbc
from wbc.messages import message_type
from wbc.motions import MOTIONS
from wbc.ros import QoSProfile
from wbc.ros.actions import ActionClient, GoalStatus
from wbc.ros.bridge.play_motion import NAME, TYPE

pytest.importorskip("cyclonedds")
pytest.importorskip("mujoco")

ROBOT = "simple_humanoid"
Twist = message_type("geometry_msgs/msg/Twist")
JointState = message_type("sensor_msgs/msg/JointState")
LONG = 3 * TIMEOUT  # some motions take that long on a busy machine


@pytest.fixture(scope="module")
def robot():
    return wbc.load(ROBOT)


@pytest.fixture(scope="module")
def com(client_node, set_parameter):
    """Messages of the CoM, stamped with plant time: their rate does not depend on the machine."""
    set_parameter("use_sim_time", True)
    made = MessageCollector(
        client_node, "geometry_msgs/msg/PointStamped", "balance/com", QoSProfile(depth=1000)
    )
    made.wait()
    return made


@pytest.fixture(scope="module")
def play(client_node, com):
    made = ActionClient(client_node, TYPE, NAME)
    assert made.wait_for_server(TIMEOUT)
    return lambda text, *options: made.send_goal(made.goal_type(motion_name=text), *options)


@pytest.fixture(scope="module")
def walk(client_node):
    """Sends a forward velocity, which is valid for half a second of the wall clock."""
    publisher = client_node.create_publisher(Twist.type_name, "cmd_vel")
    assert client_node.spin_until(lambda: publisher.get_subscription_count() > 0, TIMEOUT)

    def at(speed):
        command = Twist()
        command.linear.x = speed
        publisher.publish(command)

    return at


@pytest.fixture
def swaying(play, com):
    """Starts a long swaying motion; returns the goal once the robot sways."""

    def start_swaying():
        start = com.wait().point.y
        sent = play("sway rounds=500")
        com.wait(lambda m: abs(m.point.y - start) > 0.03)
        return sent

    return start_swaying


def service(client_node, kind, name):
    client = client_node.create_client(kind, name)
    assert client_node.spin_until(client.service_is_ready, TIMEOUT)
    return client


def wait_until_standing(com):
    """Wait until the centre of mass stays where it is."""
    points = []

    def still(message):
        points.append([message.point.x, message.point.y, message.point.z])
        return len(points) > 10 and np.ptp(points[-10:], axis=0).max() < 0.004

    com.wait(still)


def test_services_list_the_motions_and_whether_they_are_ready(client_node, com):
    listing = service(client_node, "play_motion2_msgs/srv/ListMotions", f"{NAME}/list_motions")
    names = listing.call(listing.request_type(), TIMEOUT).motion_keys
    assert names == [motion.name for motion in MOTIONS]
    readiness = service(
        client_node, "play_motion2_msgs/srv/IsMotionReady", f"{NAME}/is_motion_ready"
    )

    def ready(name):
        return readiness.call(readiness.request_type(motion_key=name), TIMEOUT).is_ready

    assert ready("wave")
    assert not ready("wive")


def test_motion_is_played_and_succeeds_when_the_robot_stands_again(play, com):
    before = com.wait().point.z
    com.clear()
    stamps = []
    sent = play("squat depth=8 times=1", lambda f: stamps.append(f.current_time))
    assert sent.accepted
    assert sent.wait_for_result(LONG)
    assert (sent.status, sent.result.success, sent.result.error) == (GoalStatus.SUCCEEDED, True, "")
    heights = [m.point.z for m in com.messages]
    assert min(heights) < before - 0.06
    com.wait()
    assert com.last.point.z == pytest.approx(before, abs=0.015)  # it settles at the start
    assert stamps


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("wive", "no motion 'wive'; did you mean 'wave'"),
        ("", "no motion ''"),
        ("squat deep=3", "squat has no parameter 'deep'; did you mean 'depth'"),
        ("squat depth=deep", "squat: depth is 'deep'; it must be a number"),
        ("squat depth", "'depth' is not of the form parameter=value"),
        ("squat depth=95", "cannot go down by 95 %"),
    ],
)
def test_motion_that_cannot_be_played_is_aborted_with_the_reason(play, text, reason):
    sent = play(text)
    assert sent.wait_for_result(LONG)
    assert sent.status is GoalStatus.ABORTED
    assert not sent.result.success
    assert reason in sent.result.error


def test_cancelled_motion_ends_with_the_robot_standing(swaying, com):
    sent = swaying()
    assert sent.cancel_goal(TIMEOUT)
    assert sent.wait_for_result(TIMEOUT)
    assert sent.status is GoalStatus.CANCELED
    wait_until_standing(com)


def test_unknown_motion_does_not_interrupt_the_motion_in_progress(play, swaying, com):
    start = com.wait().point.y
    sent = swaying()
    unknown = play("wive")
    assert unknown.wait_for_result(TIMEOUT)
    assert unknown.status is GoalStatus.ABORTED
    assert not sent.status.terminal
    com.wait(lambda m: abs(m.point.y - start) > 0.02)
    impossible = play("squat depth=95")  # supersedes the motion, but is infeasible
    assert impossible.wait_for_result(LONG)
    assert sent.status is GoalStatus.ABORTED
    wait_until_standing(com)


def test_second_motion_supersedes_the_first(play, swaying):
    first = swaying()
    second = play("bow hold=0.1 seconds=0.5")
    assert second.wait_for_result(LONG)
    assert first.status is GoalStatus.ABORTED
    assert "another goal" in first.result.error
    assert second.status is GoalStatus.SUCCEEDED


def test_velocity_command_aborts_the_motion(swaying, com, walk, client_node):
    start = com.wait().point
    sent = swaying()
    timer = client_node.create_timer(0.1, lambda: walk(0.25))
    assert sent.wait_for_result(TIMEOUT)
    assert sent.status is GoalStatus.ABORTED
    assert "velocity command from ros" in sent.result.error
    com.wait(lambda m: m.point.x > start.x + 0.1)
    timer.cancel()
    walk(0.0)
    wait_until_standing(com)


def test_robot_waves_while_it_walks(play, com, walk, client_node, robot):
    shoulder = robot.joint_index("left_shoulder_pitch")
    joints = MessageCollector(
        client_node, JointState.type_name, "joint_states", QoSProfile(depth=1000)
    )
    rest = joints.wait().position[shoulder]
    timer = client_node.create_timer(0.1, lambda: walk(0.2))
    start = com.wait().point.x
    com.wait(lambda m: m.point.x > start + 0.1)
    joints.clear()
    sent = play("wave seconds=2")
    joints.find(lambda m: abs(m.position[shoulder] - rest) > 0.5)
    now = com.wait().point.x
    com.wait(lambda m: m.point.x > now + 0.1)
    assert sent.wait_for_result(LONG)
    assert sent.status is GoalStatus.SUCCEEDED
    timer.cancel()
    walk(0.0)
    wait_until_standing(com)
    joints.close()


def test_motion_ends_when_the_client_of_its_goal_dies(com, domain):
    start = com.wait().point.y
    with PeerProcess.start_peer(
        domain, "play_motion", "sway rounds=500", configuration=SHORT_LEASE
    ) as peer:
        assert peer.first_line == "accepted"
        com.wait(lambda m: abs(m.point.y - start) > 0.03)
        peer.kill()
    wait_until_standing(com)


def test_reset_aborts_the_motion(swaying, client_node):
    sent = swaying()
    reset = service(client_node, "std_srvs/srv/Trigger", "reset_robot")
    assert reset.call(reset.request_type(), TIMEOUT).success
    assert sent.wait_for_result(TIMEOUT)
    assert sent.status is GoalStatus.ABORTED
    assert "reset" in sent.result.error


def test_example_plays_a_motion(walking_robot, com, domain):
    example = start_example(domain, "04_motion.py", "bow", "hold=0.1", "seconds=0.5")
    out, error = example.communicate(timeout=LONG)
    assert example.returncode == 0, error
    assert out.split() == ["succeeded"]

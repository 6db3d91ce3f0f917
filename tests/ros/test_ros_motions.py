"""Motions that a ROS 2 system asks for, from another process than the robot's loop and node."""

from __future__ import annotations

import numpy as np
import pytest
from rostools import PATIENCE, SHORT_LIVED, Hearer, Peer, start_example

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
ParameterType = message_type("rcl_interfaces/msg/ParameterType")
JointState = message_type("sensor_msgs/msg/JointState")
LONG = 3 * PATIENCE  # some motions take that long on a busy machine


@pytest.fixture(scope="module")
def robot():
    return wbc.load(ROBOT)


@pytest.fixture(scope="module")
def com(driver, set_parameter):
    """Its topics go by the plant's time: how often they come in it is no matter of the machine."""
    set_parameter("use_sim_time", type=ParameterType.PARAMETER_BOOL, bool_value=True)
    made = Hearer(driver, "geometry_msgs/msg/PointStamped", "balance/com", QoSProfile(depth=1000))
    made.wait()
    return made


@pytest.fixture(scope="module")
def play(driver, com):
    made = ActionClient(driver, TYPE, NAME)
    assert made.wait_for_server(PATIENCE)
    return lambda text, *told: made.send_goal(made.goal_type(motion_name=text), *told)


@pytest.fixture(scope="module")
def walk(driver):
    """Walk forward, until told otherwise; half a second of the wall clock at the most."""
    publisher = driver.create_publisher(Twist.type_name, "cmd_vel")
    assert driver.spin_until(lambda: publisher.get_subscription_count() > 0, PATIENCE)

    def at(speed):
        command = Twist()
        command.linear.x = speed
        publisher.publish(command)

    return at


@pytest.fixture
def swaying(play, com):
    """Has it sway for long; the goal, when it is well on its way."""

    def begin():
        start = com.wait().point.y
        sent = play("sway rounds=500")
        com.wait(lambda m: abs(m.point.y - start) > 0.03)
        return sent

    return begin


def service(driver, kind, name):
    client = driver.create_client(kind, name)
    assert driver.spin_until(client.service_is_ready, PATIENCE)
    return client


def stands(com):
    """The centre of mass stays where it is."""
    seen = []

    def still(message):
        seen.append([message.point.x, message.point.y, message.point.z])
        return len(seen) > 10 and np.ptp(seen[-10:], axis=0).max() < 0.004

    com.wait(still)


def test_a_ros_system_learns_which_motions_there_are(driver, com):
    listing = service(driver, "play_motion2_msgs/srv/ListMotions", f"{NAME}/list_motions")
    names = listing.call(listing.request_type(), PATIENCE).motion_keys
    assert names == [motion.name for motion in MOTIONS]
    asking = service(driver, "play_motion2_msgs/srv/IsMotionReady", f"{NAME}/is_motion_ready")

    def ready(name):
        return asking.call(asking.request_type(motion_key=name), PATIENCE).is_ready

    assert ready("wave")
    assert not ready("wive")


def test_a_motion_is_played_and_over_when_the_robot_stands_again(play, com):
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
    assert com.last.point.z == pytest.approx(before, abs=0.015)  # in the beginning it settles
    assert stamps


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("wive", "no motion 'wive'; did you mean 'wave'"),
        ("", "no motion ''"),
        ("squat deep=3", "squat has no parameter 'deep'; did you mean 'depth'"),
        ("squat depth=deep", "squat: depth is 'deep'; it must be a number"),
        ("squat depth", "'depth' is not of the form parameter=value"),
        ("squat depth=95", "cannot go down by 95 %"),
    ],
)
def test_what_cannot_be_played_is_answered_with_the_reason(play, text, why):
    sent = play(text)
    assert sent.wait_for_result(LONG)
    assert sent.status is GoalStatus.ABORTED
    assert not sent.result.success
    assert why in sent.result.error


def test_a_motion_can_be_cancelled_and_the_robot_stands(swaying, com):
    sent = swaying()
    assert sent.cancel_goal(PATIENCE)
    assert sent.wait_for_result(PATIENCE)
    assert sent.status is GoalStatus.CANCELED
    stands(com)


def test_a_motion_goes_on_when_somebody_asks_for_nonsense(play, swaying, com):
    start = com.wait().point.y
    sent = swaying()
    nonsense = play("wive")
    assert nonsense.wait_for_result(PATIENCE)
    assert nonsense.status is GoalStatus.ABORTED
    assert not sent.status.terminal
    com.wait(lambda m: abs(m.point.y - start) > 0.02)
    impossible = play("squat depth=95")  # takes its place, and cannot be done
    assert impossible.wait_for_result(LONG)
    assert sent.status is GoalStatus.ABORTED
    stands(com)


def test_a_second_motion_takes_the_place_of_the_first(play, swaying):
    first = swaying()
    second = play("bow hold=0.1 seconds=0.5")
    assert second.wait_for_result(LONG)
    assert first.status is GoalStatus.ABORTED
    assert "another goal" in first.result.error
    assert second.status is GoalStatus.SUCCEEDED


def test_a_robot_that_is_told_to_walk_leaves_off_its_motion(swaying, com, walk, driver):
    start = com.wait().point
    sent = swaying()
    again = driver.create_timer(0.1, lambda: walk(0.25))
    assert sent.wait_for_result(PATIENCE)
    assert sent.status is GoalStatus.ABORTED
    assert "velocity command from ros" in sent.result.error
    com.wait(lambda m: m.point.x > start.x + 0.1)
    again.cancel()
    walk(0.0)
    stands(com)


def test_it_waves_while_it_walks(play, com, walk, driver, robot):
    shoulder = robot.joint_index("left_shoulder_pitch")
    joints = Hearer(driver, JointState.type_name, "joint_states", QoSProfile(depth=1000))
    rest = joints.wait().position[shoulder]
    again = driver.create_timer(0.1, lambda: walk(0.2))
    start = com.wait().point.x
    com.wait(lambda m: m.point.x > start + 0.1)
    joints.clear()
    sent = play("wave seconds=2")
    joints.find(lambda m: abs(m.position[shoulder] - rest) > 0.5)
    now = com.wait().point.x
    com.wait(lambda m: m.point.x > now + 0.1)
    assert sent.wait_for_result(LONG)
    assert sent.status is GoalStatus.SUCCEEDED
    again.cancel()
    walk(0.0)
    stands(com)
    joints.close()


def test_a_motion_ends_when_who_asked_for_it_has_gone(com, domain):
    start = com.wait().point.y
    with Peer.of(domain, "play", "sway rounds=500", configuration=SHORT_LIVED) as peer:
        assert peer.first == "accepted"
        com.wait(lambda m: abs(m.point.y - start) > 0.03)
        peer.kill()
    stands(com)


def test_a_reset_ends_a_motion(swaying, driver):
    sent = swaying()
    reset = service(driver, "std_srvs/srv/Trigger", "reset_robot")
    assert reset.call(reset.request_type(), PATIENCE).success
    assert sent.wait_for_result(PATIENCE)
    assert sent.status is GoalStatus.ABORTED
    assert "reset" in sent.result.error


def test_the_example_plays_a_motion(walking, com, domain):
    example = start_example(domain, "04_motion.py", "bow", "hold=0.1", "seconds=0.5")
    out, error = example.communicate(timeout=LONG)
    assert example.returncode == 0, error
    assert out.split() == ["succeeded"]

"""A robot in physics as a node: it is seen and driven from another process, and never waits."""

from __future__ import annotations

import math
import os
import re
import signal
import time

import numpy as np
import pinocchio as pin
import pytest
from rostools import PATIENCE, SHORT_LIVED, Hearer, Peer, new_domain, node, start_example

import wbc
from wbc.messages import message_type
from wbc.motions import MotionPlayer
from wbc.ros import Network, QoSProfile
from wbc.ros.actions import ActionClient, GoalStatus
from wbc.ros.bridge import Bridge
from wbc.ros.bridge.navigate_to_pose import TYPE
from wbc.ros.qos import HIGH_RATE, LATCHED, ROSOUT
from wbc.teleop import CommandHandler

pytest.importorskip("cyclonedds")
pytest.importorskip("mujoco")

ROBOT = "simple_humanoid"
TRIGGER = "std_srvs/srv/Trigger"
Twist = message_type("geometry_msgs/msg/Twist")
ParameterType = message_type("rcl_interfaces/msg/ParameterType")
JointState = message_type("sensor_msgs/msg/JointState")


@pytest.fixture(scope="module")
def robot():
    return wbc.load(ROBOT)


@pytest.fixture
def hear(driver):
    """Subscriptions for as long as a test lasts."""
    made = []

    def subscribe(*arguments):
        made.append(Hearer(driver, *arguments))
        return made[-1]

    yield subscribe
    for one in made:
        one.close()


@pytest.fixture(scope="module")
def odom(driver):
    made = Hearer(driver, "nav_msgs/msg/Odometry", "odom")
    made.wait()
    return made


@pytest.fixture(scope="module")
def velocity(driver):
    publisher = driver.create_publisher(Twist.type_name, "cmd_vel")
    assert driver.spin_until(lambda: publisher.get_subscription_count() > 0, PATIENCE)
    return publisher


@pytest.fixture(scope="module")
def ask(driver):
    clients = {name: driver.create_client(TRIGGER, name) for name in ("push", "reset_robot")}
    return lambda name: clients[name].call(clients[name].request_type(), PATIENCE)


@pytest.fixture
def plant_time(set_parameter):
    """Topics go by the plant's time: how often they come in it is no matter of the machine."""
    set_parameter("use_sim_time", type=ParameterType.PARAMETER_BOOL, bool_value=True)
    yield
    set_parameter("use_sim_time", type=ParameterType.PARAMETER_BOOL, bool_value=False)


@pytest.fixture(scope="module")
def diagnostics(driver, set_parameter):
    set_parameter(
        "diagnostic_updater.period", type=ParameterType.PARAMETER_DOUBLE, double_value=0.1
    )
    return Hearer(driver, "diagnostic_msgs/msg/DiagnosticArray", "/diagnostics")


@pytest.fixture(scope="module")
def walk_to(driver):
    made = ActionClient(driver, TYPE, "navigate_to_pose")
    assert made.wait_for_server(PATIENCE)
    return made


@pytest.fixture
def anew(ask, odom):
    """The robot stands where it stood at first."""
    assert ask("reset_robot").success
    odom.wait(lambda m: place(m)[0] < 0.05)


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def place(message):
    position = message.pose.pose.position
    return np.array([position.x, position.y])


def speed(message):
    linear = message.twist.twist.linear
    return math.hypot(linear.x, linear.y)


def comes_to_rest(odom, diagnostics):
    """The gait comes to a stand, and the robot stays where it is."""

    def phase(message):
        return {v.key: v.value for v in message.status[0].values}["phase"] == "stand"

    diagnostics.wait(phase)
    there = place(odom.wait(lambda m: speed(m) < 0.05))
    odom.node.spin(timeout_sec=0.2)
    assert np.linalg.norm(place(odom.wait()) - there) < 0.03


def goal(client, x, y=0.0, heading=0.0, frame=""):
    request = client.goal_type()
    request.pose.header.frame_id = frame
    request.pose.pose.position.x, request.pose.pose.position.y = x, y
    request.pose.pose.orientation.z = math.sin(heading / 2.0)
    request.pose.pose.orientation.w = math.cos(heading / 2.0)
    return request


def test_joint_states_have_position_velocity_and_effort(hear, driver, robot):
    heard = hear("sensor_msgs/msg/JointState", "joint_states")
    message = heard.wait()
    assert tuple(message.name) == robot.joint_names
    knee = robot.joint_index("right_knee")
    assert message.position[knee] == pytest.approx(robot.q_nominal[7 + knee], abs=0.1)
    assert len(message.velocity) == robot.na
    assert np.abs(message.effort).max() > 1.0
    assert np.all(np.abs(message.effort) <= robot.tau_max)
    assert message.header.stamp.sec == pytest.approx(time.time(), abs=60.0)


def test_the_parameter_sets_the_rate_of_joint_states(
    hear, set_parameter, try_parameter, plant_time
):
    heard = hear("sensor_msgs/msg/JointState", "joint_states", QoSProfile(depth=1000))

    def gap(rate):
        set_parameter("update_rate", type=ParameterType.PARAMETER_DOUBLE, double_value=rate)
        heard.wait(lambda _: len(heard) > 12)
        return float(np.median(np.diff([seconds(m.header.stamp) for m in heard.messages])))

    assert gap(10.0) == pytest.approx(0.1)
    assert gap(50.0) == pytest.approx(0.02)
    too_fast = try_parameter("update_rate", type=ParameterType.PARAMETER_DOUBLE, double_value=501.0)
    assert "1 to 500" in too_fast.reason


def test_tf_puts_every_link_where_the_joints_put_it(hear, driver, robot, set_parameter):
    """The chain of transforms against Pinocchio, for joint states of the very same tick.

    There are such: whatever the rates were before, topics of one rate have the same stamps.
    """
    set_parameter("update_rate", type=ParameterType.PARAMETER_DOUBLE, double_value=29.0)
    driver.spin(timeout_sec=0.2)
    for rate in ("update_rate", "state_rate"):
        set_parameter(rate, type=ParameterType.PARAMETER_DOUBLE, double_value=50.0)
    still = hear("tf2_msgs/msg/TFMessage", "/tf_static", LATCHED).wait()
    moving = hear("tf2_msgs/msg/TFMessage", "/tf", HIGH_RATE)
    odometry = hear("nav_msgs/msg/Odometry", "odom", QoSProfile(depth=1000))
    joints = hear("sensor_msgs/msg/JointState", "joint_states", QoSProfile(depth=1000))

    def stamp(header):
        return header.stamp.sec, header.stamp.nanosec

    def together():
        there = {stamp(m.header): m for m in joints.messages}
        base = {stamp(m.header): m for m in odometry.messages}
        for m in moving.messages:
            at = stamp(m.transforms[0].header)
            if at in there and at in base:
                return m, there[at]
        return None

    assert driver.spin_until(lambda: together() is not None, PATIENCE)
    tf, state = together()
    placed = {"odom": pin.SE3.Identity()}
    waiting = [*tf.transforms, *still.transforms]
    while waiting:
        rest = []
        for one in waiting:
            parent = placed.get(one.header.frame_id)
            t, r = one.transform.translation, one.transform.rotation
            local = pin.XYZQUATToSE3(np.array([t.x, t.y, t.z, r.x, r.y, r.z, r.w]))
            if parent is None:
                rest.append(one)
            else:
                assert one.child_frame_id not in placed
                placed[one.child_frame_id] = parent * local
        assert len(rest) < len(waiting), "frames that hang on nothing"
        waiting = rest
    q = robot.q_nominal.copy()
    q[:7] = pin.SE3ToXYZQUAT(placed[robot.base])
    q[7:] = state.position
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    links = [f.name for f in robot.model.frames if f.type == pin.BODY]
    assert set(placed) == {"odom", *links, *(sole.name for sole in robot.soles)}
    for name, pose in placed.items():
        if name != "odom":
            expected = data.oMf[robot.frame_id(name)]
            assert np.allclose(pose.homogeneous, expected.homogeneous, atol=1e-9), name


def test_the_description_is_latched(hear, driver, robot):
    text = hear("std_msgs/msg/String", "robot_description", LATCHED).wait().data
    assert text == robot.urdf_path.read_text("utf-8")


def test_the_feet_carry_the_weight_below_the_centre_of_mass(hear, driver, robot):
    feet = [
        hear("geometry_msgs/msg/WrenchStamped", f"sensors/wrench/{sole.name}")
        for sole in robot.soles
    ]
    com, dcm, zmp = (
        hear("geometry_msgs/msg/PointStamped", f"balance/{name}") for name in ("com", "dcm", "zmp")
    )
    every = (*feet, com, dcm, zmp)
    assert driver.spin_until(lambda: all(len(h) >= 10 for h in every), PATIENCE)
    carried = sum(np.mean([m.wrench.force.z for m in foot.messages]) for foot in feet)
    assert carried == pytest.approx(robot.weight, rel=0.1)
    assert feet[0].last.header.frame_id == "left_sole"
    assert com.last.header.frame_id == "odom"
    assert com.last.point.z == pytest.approx(robot.com_height, abs=0.1)
    assert dcm.last.point.z == pytest.approx(0.0, abs=0.02)
    assert (
        math.dist((dcm.last.point.x, dcm.last.point.y), (zmp.last.point.x, zmp.last.point.y)) < 0.1
    )


def test_diagnostics_tell_ticks_overruns_and_status(diagnostics):
    status = diagnostics.wait().status[0]
    values = {v.key: v.value for v in status.values}
    assert status.name == "wbc: control loop"
    assert status.hardware_id == ROBOT
    assert float(values["tick p50 (µs)"]) > 0.0
    assert values["overruns"].isdecimal()
    assert values["QP status"] == "ok"


def test_it_walks_while_told_and_stops_when_nobody_tells(anew, driver, velocity, odom, diagnostics):
    command = Twist()
    command.linear.x = 0.2
    timer = driver.create_timer(0.1, lambda: velocity.publish(command))
    odom.wait(lambda m: place(m)[0] > 0.2)
    timer.cancel()
    comes_to_rest(odom, diagnostics)


def test_a_velocity_that_is_no_number_is_ignored(anew, velocity, odom, driver):
    command = Twist()
    command.linear.x = math.nan
    velocity.publish(command)
    driver.spin(timeout_sec=0.5)
    assert place(odom.wait())[0] < 0.05


def test_arms_go_where_they_are_told_and_legs_do_not(hear, anew, driver, robot):
    joints = hear("sensor_msgs/msg/JointState", "joint_states")
    publisher = driver.create_publisher(JointState.type_name, "joint_commands")
    assert driver.spin_until(lambda: publisher.get_subscription_count() > 0, PATIENCE)
    elbow, knee = robot.joint_index("left_elbow"), robot.joint_index("left_knee")
    highest = robot.q_max[elbow]
    publisher.publish(JointState(name=["left_knee"], position=[1.5]))
    publisher.publish(JointState(name=["no_such_joint"], position=[1.5]))
    publisher.publish(JointState(name=["left_elbow"], position=[]))
    publisher.publish(JointState(name=["left_elbow"], position=[99.0]))  # clamped to its limit
    reached = joints.wait(lambda m: abs(m.position[elbow] - highest) < 0.1)
    assert reached.position[knee] < 1.0


def test_a_trajectory_is_followed(hear, anew, driver, robot):
    joints = hear("sensor_msgs/msg/JointState", "joint_states")
    kind = message_type("trajectory_msgs/msg/JointTrajectory")
    point = message_type("trajectory_msgs/msg/JointTrajectoryPoint")
    publisher = driver.create_publisher(kind.type_name, "joint_trajectory")
    assert driver.spin_until(lambda: publisher.get_subscription_count() > 0, PATIENCE)
    pitch = robot.joint_index("right_shoulder_pitch")
    start = robot.q_nominal[7 + pitch]
    points = []
    for nanoseconds, offset in ((200_000_000, -0.2), (500_000_000, -0.5)):
        one = point(positions=[start + offset])
        one.time_from_start.nanosec = nanoseconds
        points.append(one)
    publisher.publish(kind(joint_names=["right_shoulder_pitch"], points=points))
    joints.wait(lambda m: abs(m.position[pitch] - (start - 0.5)) < 0.05)


def test_a_push_makes_the_dcm_jump(hear, anew, ask, plant_time):
    dcm = hear("geometry_msgs/msg/PointStamped", "balance/dcm", QoSProfile(depth=1000))
    still = dcm.wait().point.y
    answer = ask("push")
    assert answer.success
    assert "N·s over 0.1 s" in answer.message
    # It may be over before the answer is here.
    dcm.find(lambda m: m.point.y > still + 0.015)


def test_it_walks_to_a_pose_and_tells_how_far_it_is(anew, walk_to, odom):
    remaining = []
    sent = walk_to.send_goal(goal(walk_to, 0.4), lambda f: remaining.append(f.distance_remaining))
    assert sent.accepted
    assert sent.wait_for_result(3 * PATIENCE)
    assert sent.status is GoalStatus.SUCCEEDED, sent.result
    assert np.linalg.norm(place(odom.wait()) - (0.4, 0.0)) < 0.12
    assert remaining[0] > 0.3
    assert remaining[-1] < 0.2


def test_it_stops_and_stands_when_the_goal_is_cancelled(anew, walk_to, odom, diagnostics):
    sent = walk_to.send_goal(goal(walk_to, 30.0))
    odom.wait(lambda m: place(m)[0] > 0.1)
    assert sent.cancel_goal()
    assert sent.wait_for_result(PATIENCE)
    assert sent.status is GoalStatus.CANCELED
    comes_to_rest(odom, diagnostics)


def test_it_stops_when_who_sent_the_goal_is_killed(anew, domain, odom, diagnostics):
    arguments = ("30.0", "navigate_to_pose")
    with Peer.of(domain, "pursue", *arguments, configuration=SHORT_LIVED) as peer:
        assert peer.first == "accepted"
        odom.wait(lambda m: place(m)[0] > 0.1)
        peer.kill()
    comes_to_rest(odom, diagnostics)


def test_a_hand_on_the_stick_takes_over(anew, walk_to, velocity):
    sent = walk_to.send_goal(goal(walk_to, 30.0))
    command = Twist()
    command.linear.x = -0.1
    velocity.publish(command)
    assert sent.wait_for_result(PATIENCE)
    assert sent.status is GoalStatus.ABORTED
    assert "took over" in sent.result.error_msg


def test_the_example_drives_it(anew, domain):
    example = start_example(domain, "03_drive.py", "--seconds", "1", "--goal", "0.2")
    out, error = example.communicate(timeout=3 * PATIENCE)
    assert example.returncode == 0, error
    assert re.search(r"^\d\.\d\d m to go$", out, re.MULTILINE)
    assert out.splitlines()[-1].strip() == "succeeded"


@pytest.mark.parametrize(
    "bad", [{"x": math.nan}, {"x": 1.0, "frame": "no_such_frame"}, {"x": 1.0, "heading": math.nan}]
)
def test_a_goal_that_is_none_is_rejected(walk_to, bad):
    assert walk_to.send_goal(goal(walk_to, **bad)).accepted is False


def test_a_reset_ends_the_goal_and_sets_it_back(anew, walk_to, ask, odom):
    sent = walk_to.send_goal(goal(walk_to, 30.0))
    odom.wait(lambda m: place(m)[0] > 0.1)
    answer = ask("reset_robot")
    assert (answer.success, answer.message) == (True, "standing")
    assert sent.wait_for_result(PATIENCE)
    assert sent.status is GoalStatus.ABORTED
    assert place(odom.wait(lambda m: place(m)[0] < 0.05))[0] < 0.05


def test_the_clock_is_the_plants_and_goes_on_over_a_reset(hear, anew, ask):
    clock = hear("rosgraph_msgs/msg/Clock", "/clock")
    before = seconds(clock.wait().clock)
    assert 0.0 < before < 3000.0
    clock.wait(lambda m: seconds(m.clock) > before + 0.5)
    assert ask("reset_robot").success
    clock.wait(lambda m: seconds(m.clock) > before + 1.0)
    times = [seconds(m.clock) for m in clock.messages]
    assert times == sorted(times)


def test_with_sim_time_messages_carry_the_time_of_the_clock(
    hear, driver, set_parameter, diagnostics
):
    clock = hear("rosgraph_msgs/msg/Clock", "/clock", QoSProfile(depth=1000))
    joints = hear("sensor_msgs/msg/JointState", "joint_states", QoSProfile(depth=1000))
    clock.wait()
    set_parameter("use_sim_time", type=ParameterType.PARAMETER_BOOL, bool_value=True)
    joints.wait(lambda m: m.header.stamp.sec < 1_000_000)
    stamp, sent = seconds(joints.last.header.stamp), joints.infos[-1].source_timestamp
    assert driver.spin_until(lambda: clock.infos[-1].source_timestamp > sent, PATIENCE)
    told = [
        (info.source_timestamp, seconds(m.clock))
        for info, m in zip(clock.infos, clock.messages, strict=True)
    ]
    before = max(time for at, time in told if at < sent)
    after = min(time for at, time in told if at > sent)
    assert before <= stamp <= after
    diagnostics.wait(lambda m: m.header.stamp.sec < 1_000_000)
    set_parameter("use_sim_time", type=ParameterType.PARAMETER_BOOL, bool_value=False)
    joints.wait(lambda m: m.header.stamp.sec > 1_000_000)


def test_what_it_says_is_on_rosout_for_who_comes_late_too(hear, velocity):
    bad = Twist()
    bad.linear.x = math.inf
    early = hear("rcl_interfaces/msg/Log", "/rosout", ROSOUT)
    velocity.publish(bad)
    for come in (lambda: early, lambda: hear("rcl_interfaces/msg/Log", "/rosout", ROSOUT)):
        said = come().wait(lambda m: "cmd_vel" in m.msg and "inf" in m.msg)
        assert (said.level, said.name, said.file) == (30, "wbc", "cmd_vel.py")
        assert said.function
        assert said.line > 0
        assert seconds(said.stamp) == pytest.approx(time.time(), abs=60.0)


def test_a_robot_that_fell_lies_there_until_it_is_reset(
    anew, hear, set_parameter, ask, odom, diagnostics
):
    rosout = hear("rcl_interfaces/msg/Log", "/rosout", ROSOUT)
    set_parameter(
        "push_impulse",
        type=ParameterType.PARAMETER_DOUBLE_ARRAY,
        double_array_value=[0.0, 100.0, 0.0],
    )
    ask("push")
    message = diagnostics.wait(lambda m: m.status[0].message == "fallen")
    assert message.status[0].level == 2  # ERROR
    rosout.find(lambda m: (m.msg, m.level) == ("the robot fell", 40))
    odom.wait()  # its sensors do not die
    assert ask("reset_robot").success
    diagnostics.wait(lambda m: m.status[0].message != "fallen")
    odom.wait(lambda m: m.pose.pose.position.z > 0.7)


def test_the_node_goes_when_its_loop_is_killed(walking, driver, odom):
    """The last test that needs them: the loop's process dies and cannot say so."""
    walking.kill()
    assert driver.spin_until(lambda: odom.subscription.get_publisher_count() == 0, PATIENCE)


def test_the_loop_goes_on_standing_when_the_node_is_killed(robot):
    player = MotionPlayer(robot)
    plant = wbc.sim.Mujoco(robot)
    domain = new_domain()
    with (
        CommandHandler(player, plant, owns_clock=False) as handler,
        Bridge(handler, network=Network(domain)) as bridge,
        node("d", domain) as driver,
    ):
        velocity = driver.create_publisher(Twist.type_name, "cmd_vel")
        assert driver.spin_until(lambda: velocity.get_subscription_count() > 0, PATIENCE)
        command = Twist()
        command.linear.x = 0.2
        wanted = []

        def before_tick(now):
            if now < 0.7:
                velocity.publish(command)
            if 0.7 <= now < 0.7 + 1.5 * player.dt and bridge.alive:
                os.kill(bridge.pid, signal.SIGKILL)
            handler.before_tick(now)
            wanted.append(player.velocity[0])

        # In real time: a velocity lasts half a second of the wall clock.
        report = wbc.run(
            player, plant, 1.8, observers=[bridge], before_tick=before_tick, real_time=True
        )
        assert max(wanted) == pytest.approx(0.2)
        assert wanted[-1] == 0.0
        assert not bridge.alive
    assert report.survived

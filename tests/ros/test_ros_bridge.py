"""A simulated robot as a node: it is observed and commanded from another process."""

from __future__ import annotations

import math
import os
import re
import signal
import time

import numpy as np
import pinocchio as pin
import pytest
from rostools import (
    SHORT_LEASE,
    TIMEOUT,
    MessageCollector,
    PeerProcess,
    node,
    start_example,
    unused_domain,
)

import wbc
from wbc.messages import message_type
from wbc.motions import MotionPlayer
from wbc.ros import Network, QoSProfile
from wbc.ros.actions import ActionClient, GoalStatus
from wbc.ros.bridge import Bridge
from wbc.ros.bridge.graph_monitor import GraphMonitor
from wbc.ros.bridge.navigate_to_pose import TYPE
from wbc.ros.qos import HIGH_RATE, LATCHED, ROSOUT
from wbc.teleop import CommandHandler
from wbc.topics.standard_frames import standard_frames

pytest.importorskip("cyclonedds")
pytest.importorskip("mujoco")

ROBOT = "simple_humanoid"
TRIGGER = "std_srvs/srv/Trigger"
Twist = message_type("geometry_msgs/msg/Twist")
JointState = message_type("sensor_msgs/msg/JointState")


@pytest.fixture(scope="module")
def robot():
    return wbc.load(ROBOT)


@pytest.fixture
def subscribe(client_node):
    """Creates subscriptions that are removed at the end of the test."""
    made = []

    def subscribe(*arguments):
        made.append(MessageCollector(client_node, *arguments))
        return made[-1]

    yield subscribe
    for one in made:
        one.close()


@pytest.fixture(scope="module")
def odom(client_node):
    made = MessageCollector(client_node, "nav_msgs/msg/Odometry", "odom")
    made.wait()
    return made


@pytest.fixture(scope="module")
def velocity(client_node):
    publisher = client_node.create_publisher(Twist.type_name, "cmd_vel")
    assert client_node.spin_until(lambda: publisher.get_subscription_count() > 0, TIMEOUT)
    return publisher


@pytest.fixture(scope="module")
def call_trigger(client_node):
    clients = {name: client_node.create_client(TRIGGER, name) for name in ("push", "reset_robot")}
    return lambda name: clients[name].call(clients[name].request_type(), TIMEOUT)


@pytest.fixture
def plant_time(set_parameter):
    """Stamps with the plant's time: the rate of topics in it does not depend on the machine."""
    set_parameter("use_sim_time", True)
    yield
    set_parameter("use_sim_time", False)


@pytest.fixture(scope="module")
def diagnostics(client_node, set_parameter):
    set_parameter("diagnostic_updater.period", 0.1)
    return MessageCollector(client_node, "diagnostic_msgs/msg/DiagnosticArray", "/diagnostics")


@pytest.fixture(scope="module")
def navigate(client_node):
    made = ActionClient(client_node, TYPE, "navigate_to_pose")
    assert made.wait_for_server(TIMEOUT)
    return made


@pytest.fixture
def reset(call_trigger, odom):
    """Resets the robot to the start."""
    assert call_trigger("reset_robot").success
    odom.wait(lambda m: position(m)[0] < 0.05)


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def position(message):
    point = message.pose.pose.position
    return np.array([point.x, point.y])


def speed(message):
    linear = message.twist.twist.linear
    return math.hypot(linear.x, linear.y)


def assert_comes_to_rest(odom, diagnostics):
    """Check that the gait stands and that the robot does not move."""

    def is_standing(message):
        return {v.key: v.value for v in message.status[0].values}["phase"] == "stand"

    diagnostics.wait(is_standing)
    before = position(odom.wait(lambda m: speed(m) < 0.05))
    odom.node.spin(timeout_sec=0.2)
    assert np.linalg.norm(position(odom.wait()) - before) < 0.03


def goal(client, x, y=0.0, heading=0.0, frame=""):
    request = client.goal_type()
    request.pose.header.frame_id = frame
    request.pose.pose.position.x, request.pose.pose.position.y = x, y
    request.pose.pose.orientation.z = math.sin(heading / 2.0)
    request.pose.pose.orientation.w = math.cos(heading / 2.0)
    return request


def test_joint_states_have_position_velocity_and_effort(subscribe, client_node, robot):
    received = subscribe("sensor_msgs/msg/JointState", "joint_states")
    message = received.wait()
    assert tuple(message.name) == robot.joint_names
    knee = robot.joint_index("right_knee")
    assert message.position[knee] == pytest.approx(robot.q_nominal[7 + knee], abs=0.1)
    assert len(message.velocity) == robot.na
    assert np.abs(message.effort).max() > 1.0
    assert np.all(np.abs(message.effort) <= robot.tau_max)
    assert message.header.stamp.sec == pytest.approx(time.time(), abs=60.0)


def test_parameter_sets_the_rate_of_joint_states(
    subscribe, set_parameter, try_parameter, plant_time
):
    received = subscribe("sensor_msgs/msg/JointState", "joint_states", QoSProfile(depth=1000))

    def assert_gaps_become(gap):
        """Samples from before the change may still be in the reader's queue."""
        set_parameter("update_rate", 1.0 / gap)
        received.wait(
            lambda _: (
                len(received) > 12
                and np.allclose(
                    np.diff([seconds(m.header.stamp) for m in received.messages[-12:]]), gap
                )
            )
        )

    assert_gaps_become(0.1)
    assert_gaps_become(0.02)
    too_fast = try_parameter("update_rate", 501.0)
    assert "1 to 500" in too_fast.reason


def test_tf_agrees_with_the_kinematics_of_the_joint_states(
    subscribe, client_node, robot, set_parameter
):
    """Transforms are compared with Pinocchio's for joint states of the same tick.

    Such joint states exist because topics of equal rates have equal stamps.
    """
    set_parameter("update_rate", 29.0)
    client_node.spin(timeout_sec=0.2)
    for rate in ("update_rate", "state_rate"):
        set_parameter(rate, 50.0)
    static = subscribe("tf2_msgs/msg/TFMessage", "/tf_static", LATCHED).wait()
    dynamic = subscribe("tf2_msgs/msg/TFMessage", "/tf", HIGH_RATE)
    odometry = subscribe("nav_msgs/msg/Odometry", "odom", QoSProfile(depth=1000))
    joints = subscribe("sensor_msgs/msg/JointState", "joint_states", QoSProfile(depth=1000))

    def stamp(header):
        return header.stamp.sec, header.stamp.nanosec

    def together():
        there = {stamp(m.header): m for m in joints.messages}
        base = {stamp(m.header): m for m in odometry.messages}
        for m in dynamic.messages:
            at = stamp(m.transforms[0].header)
            if at in there and at in base:
                return m, there[at]
        return None

    assert client_node.spin_until(lambda: together() is not None, TIMEOUT)
    tf, state = together()
    placed = {"odom": pin.SE3.Identity()}
    waiting = [*tf.transforms, *static.transforms]
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
        assert len(rest) < len(waiting), "frames without a known parent"
        waiting = rest
    q = robot.q_nominal.copy()
    q[:7] = pin.SE3ToXYZQUAT(placed[robot.base])
    q[7:] = state.position
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    links = [f.name for f in robot.model.frames if f.type == pin.BODY]
    standard = {"base_footprint", *(frame.name for frame in standard_frames(robot))}
    assert set(placed) == {"odom", *links, *(sole.name for sole in robot.soles), *standard}
    for name, pose in placed.items():
        if name not in ("odom", *standard):
            expected = data.oMf[robot.frame_id(name)]
            assert np.allclose(pose.homogeneous, expected.homogeneous, atol=1e-9), name


def test_description_is_latched(subscribe, client_node, robot):
    text = subscribe("std_msgs/msg/String", "robot_description", LATCHED).wait().data
    assert text == robot.urdf_path.read_text("utf-8")


def test_contact_forces_carry_the_weight_below_the_centre_of_mass(subscribe, client_node, robot):
    feet = [
        subscribe("geometry_msgs/msg/WrenchStamped", f"sensors/wrench/{sole.name}")
        for sole in robot.soles
    ]
    com, dcm, zmp = (
        subscribe("geometry_msgs/msg/PointStamped", f"balance/{name}")
        for name in ("com", "dcm", "zmp")
    )
    every = (*feet, com, dcm, zmp)
    assert client_node.spin_until(lambda: all(len(h) >= 10 for h in every), TIMEOUT)
    carried = sum(np.mean([m.wrench.force.z for m in foot.messages]) for foot in feet)
    assert carried == pytest.approx(robot.weight, rel=0.1)
    assert feet[0].last.header.frame_id == "left_sole"
    assert com.last.header.frame_id == "odom"
    assert com.last.point.z == pytest.approx(robot.com_height, abs=0.1)
    assert dcm.last.point.z == pytest.approx(0.0, abs=0.02)
    assert (
        math.dist((dcm.last.point.x, dcm.last.point.y), (zmp.last.point.x, zmp.last.point.y)) < 0.1
    )


def test_diagnostics_report_tick_times_overruns_and_status(diagnostics):
    status = diagnostics.wait().status[0]
    values = {v.key: v.value for v in status.values}
    assert status.name == "wbc: control loop"
    assert status.hardware_id == ROBOT
    assert float(values["tick p50 (µs)"]) > 0.0
    assert values["overruns"].isdecimal()
    assert values["QP status"] == "ok"


def test_robot_walks_while_it_gets_velocities_and_stops_without(
    reset, client_node, velocity, odom, diagnostics
):
    command = Twist()
    command.linear.x = 0.2
    timer = client_node.create_timer(0.1, lambda: velocity.publish(command))
    odom.wait(lambda m: position(m)[0] > 0.2)
    timer.cancel()
    assert_comes_to_rest(odom, diagnostics)


def test_velocity_that_is_not_finite_is_ignored(reset, velocity, odom, client_node):
    command = Twist()
    command.linear.x = math.nan
    velocity.publish(command)
    client_node.spin(timeout_sec=0.5)
    assert position(odom.wait())[0] < 0.05


def test_joint_commands_move_arms_but_not_legs(subscribe, reset, client_node, robot):
    joints = subscribe("sensor_msgs/msg/JointState", "joint_states")
    publisher = client_node.create_publisher(JointState.type_name, "joint_commands")
    assert client_node.spin_until(lambda: publisher.get_subscription_count() > 0, TIMEOUT)
    elbow, knee = robot.joint_index("left_elbow"), robot.joint_index("left_knee")
    highest = robot.q_max[elbow]
    publisher.publish(JointState(name=["left_knee"], position=[1.5]))
    publisher.publish(JointState(name=["no_such_joint"], position=[1.5]))
    publisher.publish(JointState(name=["left_elbow"], position=[]))
    publisher.publish(JointState(name=["left_elbow"], position=[99.0]))  # clamped to its limit
    reached = joints.wait(lambda m: abs(m.position[elbow] - highest) < 0.1)
    assert reached.position[knee] < 1.0


def test_joint_trajectory_is_followed(subscribe, reset, client_node, robot):
    joints = subscribe("sensor_msgs/msg/JointState", "joint_states")
    kind = message_type("trajectory_msgs/msg/JointTrajectory")
    point = message_type("trajectory_msgs/msg/JointTrajectoryPoint")
    publisher = client_node.create_publisher(kind.type_name, "joint_trajectory")
    assert client_node.spin_until(lambda: publisher.get_subscription_count() > 0, TIMEOUT)
    pitch = robot.joint_index("right_shoulder_pitch")
    start = robot.q_nominal[7 + pitch]
    points = []
    for nanoseconds, offset in ((200_000_000, -0.2), (500_000_000, -0.5)):
        one = point(positions=[start + offset])
        one.time_from_start.nanosec = nanoseconds
        points.append(one)
    publisher.publish(kind(joint_names=["right_shoulder_pitch"], points=points))
    joints.wait(lambda m: abs(m.position[pitch] - (start - 0.5)) < 0.05)


def test_trajectory_goal_is_followed_at_its_own_velocities(reset, client_node, robot):
    client = ActionClient(
        client_node, "control_msgs/action/FollowJointTrajectory", "follow_joint_trajectory"
    )
    assert client.wait_for_server(TIMEOUT)
    index = robot.joint_names.index("left_shoulder_pitch")
    start = float(robot.q_nominal[7 + index])
    point = message_type("trajectory_msgs/msg/JointTrajectoryPoint")
    request = client.goal_type()
    request.trajectory.joint_names = ["left_shoulder_pitch"]
    request.trajectory.points = [
        point(positions=[start], velocities=[0.0]),
        point(positions=[start + 0.3], velocities=[0.0]),
    ]
    request.trajectory.points[1].time_from_start.sec = 1
    sent = client.send_goal(request)
    assert sent.accepted
    assert sent.wait_for_result(TIMEOUT)
    assert (sent.status, sent.result.error_code) == (GoalStatus.SUCCEEDED, 0), sent.result
    request.trajectory.points[1].positions = [start + 30.0]
    assert not client.send_goal(request).accepted


def test_push_shifts_the_dcm(subscribe, reset, call_trigger, plant_time):
    dcm = subscribe("geometry_msgs/msg/PointStamped", "balance/dcm", QoSProfile(depth=1000))
    before = dcm.wait().point.y
    response = call_trigger("push")
    assert response.success
    assert "N·s over 0.1 s" in response.message
    # The push may be over before the response arrives.
    dcm.find(lambda m: m.point.y > before + 0.015)


def test_robot_walks_to_a_pose_and_reports_the_remaining_distance(reset, navigate, odom):
    remaining = []
    sent = navigate.send_goal(goal(navigate, 0.4), lambda f: remaining.append(f.distance_remaining))
    assert sent.accepted
    assert sent.wait_for_result(3 * TIMEOUT)
    assert sent.status is GoalStatus.SUCCEEDED, sent.result
    assert np.linalg.norm(position(odom.wait()) - (0.4, 0.0)) < 0.12
    assert remaining[0] > 0.3
    assert remaining[-1] < 0.2


def test_cancelled_goal_ends_with_the_robot_standing(reset, navigate, odom, diagnostics):
    sent = navigate.send_goal(goal(navigate, 30.0))
    odom.wait(lambda m: position(m)[0] > 0.1)
    assert sent.cancel_goal()
    assert sent.wait_for_result(TIMEOUT)
    assert sent.status is GoalStatus.CANCELED
    assert_comes_to_rest(odom, diagnostics)


def test_robot_stops_when_the_client_of_its_goal_is_killed(reset, domain, odom, diagnostics):
    arguments = ("30.0", "navigate_to_pose")
    with PeerProcess.start_peer(domain, "send_goal", *arguments, configuration=SHORT_LEASE) as peer:
        assert peer.first_line == "accepted"
        odom.wait(lambda m: position(m)[0] > 0.1)
        peer.kill()
    assert_comes_to_rest(odom, diagnostics)


def test_velocity_command_aborts_the_goal(reset, navigate, velocity):
    sent = navigate.send_goal(goal(navigate, 30.0))
    command = Twist()
    command.linear.x = -0.1
    velocity.publish(command)
    assert sent.wait_for_result(TIMEOUT)
    assert sent.status is GoalStatus.ABORTED
    assert "took over" in sent.result.error_msg


def test_example_drives_the_robot(reset, domain):
    example = start_example(domain, "03_drive.py", "--seconds", "1", "--goal", "0.2")
    out, error = example.communicate(timeout=3 * TIMEOUT)
    assert example.returncode == 0, error
    assert re.search(r"^\d\.\d\d m to go$", out, re.MULTILINE)
    assert out.splitlines()[-1].strip() == "succeeded"


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        ({"x": math.nan}, "a number of the pose is not finite"),
        ({"x": 1.0, "frame": "unknown"}, "connects the frame 'unknown' with 'odom'"),
        ({"x": 1.0, "heading": math.nan}, "a number of the pose is not finite"),
    ],
)
def test_invalid_goal_is_rejected_with_the_reason_on_rosout(odom, navigate, subscribe, bad, reason):
    assert navigate.send_goal(goal(navigate, **bad)).accepted is False
    log = subscribe("rcl_interfaces/msg/Log", "/rosout", ROSOUT)
    log.find(lambda m: reason in m.msg and m.level == 30)


def test_invalid_goal_pose_is_rejected_with_the_reason_on_rosout(odom, client_node, subscribe):
    log = subscribe("rcl_interfaces/msg/Log", "/rosout", ROSOUT)
    publisher = client_node.create_publisher("geometry_msgs/msg/PoseStamped", "goal_pose")
    assert client_node.spin_until(publisher.get_subscription_count, TIMEOUT)
    pose = publisher.msg_type()
    pose.pose.orientation.w = 0.0
    publisher.publish(pose)
    log.wait(lambda m: "navigate_to_pose: rejected a goal: the norm of the quaternion" in m.msg)


def test_reset_aborts_the_goal_and_moves_the_robot_to_the_start(
    reset, navigate, call_trigger, odom
):
    sent = navigate.send_goal(goal(navigate, 30.0))
    odom.wait(lambda m: position(m)[0] > 0.1)
    response = call_trigger("reset_robot")
    assert (response.success, response.message) == (True, "standing")
    assert sent.wait_for_result(TIMEOUT)
    assert sent.status is GoalStatus.ABORTED
    assert position(odom.wait(lambda m: position(m)[0] < 0.05))[0] < 0.05


def test_stamped_velocity_drives_the_robot_too(reset, client_node, odom):
    publisher = client_node.create_publisher("geometry_msgs/msg/TwistStamped", "cmd_vel")
    assert client_node.spin_until(publisher.get_subscription_count, TIMEOUT)
    message = publisher.msg_type()
    message.twist.linear.x = 0.2
    timer = client_node.create_timer(0.1, lambda: publisher.publish(message))
    odom.wait(lambda m: position(m)[0] > 0.1)
    timer.cancel()


def test_goal_pose_in_a_map_is_transformed_by_tf(reset, client_node, subscribe):
    """The map's origin is 30 m behind that of odom."""
    status = subscribe(
        "action_msgs/msg/GoalStatusArray", "navigate_to_pose/_action/status", LATCHED
    )
    feedback = subscribe(
        "nav2_msgs/action/NavigateToPose_FeedbackMessage", "navigate_to_pose/_action/feedback"
    )
    tf = client_node.create_publisher("tf2_msgs/msg/TFMessage", "/tf_static", LATCHED)
    transform = message_type("geometry_msgs/msg/TransformStamped")(child_frame_id="odom")
    transform.header.frame_id = "map"
    transform.transform.translation.x = 30.0
    tf.publish(tf.msg_type(transforms=[transform]))
    assert client_node.spin_until(tf.get_subscription_count, TIMEOUT)
    publisher = client_node.create_publisher("geometry_msgs/msg/PoseStamped", "goal_pose")
    assert client_node.spin_until(publisher.get_subscription_count, TIMEOUT)
    pose = publisher.msg_type()
    pose.header.frame_id, pose.pose.position.x = "map", 30.7
    # Refused until the transform has arrived, which may be after the pose.
    timer = client_node.create_timer(0.5, lambda: publisher.publish(pose))
    first = feedback.wait().feedback
    timer.cancel()
    assert first.distance_remaining == pytest.approx(0.7, abs=0.2)
    left = seconds(first.estimated_time_remaining)
    assert left > 3.0
    succeeded = GoalStatus.SUCCEEDED
    status.find(lambda m: any(s.status == succeeded for s in m.status_list[-1:]), 3.0 * TIMEOUT)
    took = seconds(feedback.last.feedback.navigation_time)
    assert 0.6 * took < left < 1.6 * took


def test_gait_parameters_and_gains_are_parameters_of_the_node(try_parameter, set_parameter):
    set_parameter("gait.swing_height", 0.05)
    refused = try_parameter("gait.swing_height", 5.0)
    assert not refused.successful
    assert "out of its range" in refused.reason
    set_parameter("com.weight", 2000.0)


def test_another_node_of_the_same_name_is_reported(caplog):
    domain = unused_domain()
    with node("wbc", domain) as first, node("wbc", domain):
        GraphMonitor(first)
        assert first.spin_until(lambda: "another node of this domain" in caplog.text, TIMEOUT)


def test_clock_is_plant_time_and_continuous_over_a_reset(subscribe, reset, call_trigger):
    clock = subscribe("rosgraph_msgs/msg/Clock", "/clock")
    before = seconds(clock.wait().clock)
    assert 0.0 < before < 3000.0
    clock.wait(lambda m: seconds(m.clock) > before + 0.5)
    assert call_trigger("reset_robot").success
    clock.wait(lambda m: seconds(m.clock) > before + 1.0)
    times = [seconds(m.clock) for m in clock.messages]
    assert times == sorted(times)


def test_messages_carry_the_time_of_the_clock_with_sim_time(
    subscribe, client_node, set_parameter, diagnostics
):
    clock = subscribe("rosgraph_msgs/msg/Clock", "/clock", QoSProfile(depth=1000))
    joints = subscribe("sensor_msgs/msg/JointState", "joint_states", QoSProfile(depth=1000))
    clock.wait()
    set_parameter("use_sim_time", True)
    joints.wait(lambda m: m.header.stamp.sec < 1_000_000)
    stamp, sent = seconds(joints.last.header.stamp), joints.infos[-1].source_timestamp
    assert client_node.spin_until(lambda: clock.infos[-1].source_timestamp > sent, TIMEOUT)
    clock_times = [
        (info.source_timestamp, seconds(m.clock))
        for info, m in zip(clock.infos, clock.messages, strict=True)
    ]
    before = max(time for at, time in clock_times if at < sent)
    after = min(time for at, time in clock_times if at > sent)
    assert before <= stamp <= after
    diagnostics.wait(lambda m: m.header.stamp.sec < 1_000_000)
    set_parameter("use_sim_time", False)
    joints.wait(lambda m: m.header.stamp.sec > 1_000_000)


def test_log_messages_are_on_rosout_also_for_late_subscribers(subscribe, velocity):
    bad = Twist()
    bad.linear.x = math.inf
    early = subscribe("rcl_interfaces/msg/Log", "/rosout", ROSOUT)
    velocity.publish(bad)
    for create in (lambda: early, lambda: subscribe("rcl_interfaces/msg/Log", "/rosout", ROSOUT)):
        message = create().wait(lambda m: "cmd_vel" in m.msg and "inf" in m.msg)
        assert (message.level, message.name, message.file) == (30, "wbc", "cmd_vel.py")
        assert message.function
        assert message.line > 0
        assert seconds(message.stamp) == pytest.approx(time.time(), abs=60.0)


def test_fallen_robot_is_reported_until_it_is_reset(
    reset, subscribe, set_parameter, call_trigger, odom, diagnostics
):
    rosout = subscribe("rcl_interfaces/msg/Log", "/rosout", ROSOUT)
    set_parameter(
        "push_impulse",
        [0.0, 100.0, 0.0],
    )
    call_trigger("push")
    message = diagnostics.wait(lambda m: m.status[0].message == "fallen")
    assert message.status[0].level == 2  # ERROR
    rosout.find(lambda m: (m.msg, m.level) == ("the robot fell", 40))
    odom.wait()  # it is still published
    assert call_trigger("reset_robot").success
    diagnostics.wait(lambda m: m.status[0].message != "fallen")
    odom.wait(lambda m: m.pose.pose.position.z > 0.7)


def test_node_disappears_when_its_loop_is_killed(walking_robot, client_node, odom):
    """This must be the last test that uses the robot's process."""
    walking_robot.kill()
    assert client_node.spin_until(lambda: odom.subscription.get_publisher_count() == 0, TIMEOUT)


def test_loop_stops_walking_and_continues_when_the_node_is_killed(robot):
    player = MotionPlayer(robot)
    plant = wbc.sim.Mujoco(robot)
    domain = unused_domain()
    with (
        CommandHandler(player, plant, owns_clock=False) as handler,
        Bridge(handler, network=Network(domain)) as bridge,
        node("client", domain) as client_node,
    ):
        velocity = client_node.create_publisher(Twist.type_name, "cmd_vel")
        assert client_node.spin_until(lambda: velocity.get_subscription_count() > 0, TIMEOUT)
        command = Twist()
        command.linear.x = 0.2
        velocities = []

        def before_tick(now):
            if now < 0.7:
                velocity.publish(command)
            if 0.7 <= now < 0.7 + 1.5 * player.dt and bridge.alive:
                os.kill(bridge.pid, signal.SIGKILL)
            handler.before_tick(now)
            velocities.append(player.velocity[0])

        # In real time, because a velocity expires after half a second of the wall clock.
        report = wbc.run(
            player, plant, 1.8, observers=[bridge], before_tick=before_tick, real_time=True
        )
        assert max(velocities) == pytest.approx(0.2)
        assert velocities[-1] == 0.0
        assert not bridge.alive
    assert report.survived

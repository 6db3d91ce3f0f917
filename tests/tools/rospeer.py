"""The peer process of the tests of ROS 2: `python rospeer.py KIND DOMAIN ...`.

Each kind prints a line when it is ready, and runs until it is interrupted or its input ends.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
from typing import Any

from rostools import used_types

from wbc.messages import message_type
from wbc.ros import Network, Node, QoSProfile, RosError
from wbc.ros.actions import ActionClient, ActionServer, GoalStatus, ServerGoalHandle
from wbc.ros.dds_endpoints import DdsWriter, EndpointConfig
from wbc.ros.dds_types import raw_dds_type
from wbc.ros.qos import DEFAULT, LATCHED
from wbc.ros.stamp import stamp_now

TIMEOUT = 20_000_000_000  # ns
ACTION = "nav2_msgs/action/NavigateToPose"


def parent_has_ended() -> bool:
    """Return whether the parent has ended."""
    return bool(select.select([sys.stdin], [], [], 0.0)[0]) and not sys.stdin.readline()


def print_ready() -> None:
    print("ready", flush=True)


def echo(node: Node) -> None:
    """Decode messages of every type, encode them again and publish them.

    The publishers are latched, because their subscriptions may be discovered later.
    """
    for name in used_types():
        topic = name.replace("/", "_").lower()
        back = node.create_publisher(name, f"back/{topic}", LATCHED)
        node.create_subscription(name, f"forth/{topic}", lambda m, _, back=back: back.publish(m))
    print_ready()
    node.spin_until(parent_has_ended)


def serve(node: Node) -> None:
    """Serve a service, parameters of every kind, and an action without a robot."""
    calls = 0

    def respond(request: Any, response: Any) -> Any:
        nonlocal calls
        calls += 1
        response.success, response.message = request.data, f"called {calls} times"
        return response

    node.create_service("std_srvs/srv/SetBool", "switch", respond)
    node.declare_parameter("rate", 50.0, "Hz", bounds=(1.0, 500.0))
    node.declare_parameter("count", 3, "of things", bounds=(0, 10))
    node.declare_parameter("on", True)
    node.declare_parameter("name", "text")
    node.declare_parameter("gait.impulse", (0.0, 1.0, 2.0), "N·s", bounds=(-10.0, 10.0))
    node.declare_parameter("built", "today", read_only=True)
    goals: list[ServerGoalHandle] = []
    server = ActionServer(
        node,
        ACTION,
        "walk",
        goal_callback=lambda goal: goal.pose.pose.position.x >= 0.0,
        handle_accepted_callback=goals.append,
        cancel_callback=lambda _: True,
    )

    def advance() -> None:
        for goal in [goal for goal in goals if not goal.status.terminal]:
            if not goal.client_alive:
                print("client lost", flush=True)
                goal.finish(GoalStatus.ABORTED, server.result_type())
            elif goal.status is GoalStatus.CANCELING:
                goal.finish(GoalStatus.CANCELED, server.result_type(error_msg="cancelled"))
            else:
                position = goal.request.pose.pose.position
                goal.publish_feedback(server.feedback_type(distance_remaining=position.x))
                position.x -= 1.0
                if position.x < 0.0:
                    goal.finish(GoalStatus.SUCCEEDED, server.result_type(error_msg="arrived"))

    node.create_timer(0.02, advance)
    print_ready()
    node.spin_until(parent_has_ended)


def send_goal(node: Node, x: str, action: str) -> None:
    """Send a goal at a distance, m, and spin."""
    client = ActionClient(node, ACTION, action)
    request = client.goal_type()
    request.pose.pose.position.x = float(x)
    goal = client.send_goal(request, timeout_sec=20.0)
    print("accepted" if goal.accepted else "rejected", flush=True)
    node.spin_until(parent_has_ended)


def play_motion(node: Node, text: str) -> None:
    """Send the goal to play a motion, and spin."""
    client = ActionClient(node, "play_motion2_msgs/action/PlayMotion2", "play_motion2")
    goal = client.send_goal(client.goal_type(motion_name=text), timeout_sec=20.0)
    print("accepted" if goal.accepted else "rejected", flush=True)
    node.spin_until(parent_has_ended)


def publish_numbers(node: Node, rate: str, number: str, depth: str = "10") -> None:
    """Publish numbered joint states of 32 joints at a rate, once there is a subscriber."""
    kind = message_type("sensor_msgs/msg/JointState")
    zeros = [0.0] * 32
    names = [f"joint_{i}" for i in range(32)]
    message: Any = kind(name=names, position=zeros, velocity=zeros, effort=zeros)
    publisher = node.create_publisher(kind.type_name, "joint_states", QoSProfile(depth=int(depth)))
    sent = 0

    def publish() -> None:
        nonlocal sent
        if sent < int(number):
            message.position[0] = sent
            message.header.stamp = stamp_now()
            publisher.publish(message)
            sent += 1

    print_ready()
    node.spin_until(lambda: publisher.get_subscription_count() > 0 or parent_has_ended())
    publish()
    # The subscription may not have discovered this publisher yet.
    publisher.writer.dds.wait_for_acks(TIMEOUT)
    node.create_timer(1.0 / float(rate), publish)
    node.spin_until(parent_has_ended)


def publish_raw(node: Node, dds_type: str) -> None:
    """Publish bytes, given by input lines with a topic and hexadecimal digits."""
    writers: dict[str, DdsWriter] = {}
    print_ready()
    for line in sys.stdin:
        topic, digits = line.split()
        if topic not in writers:
            kind = raw_dds_type(dds_type)
            config = EndpointConfig(f"rt/{topic}", kind, DEFAULT)
            writers[topic] = DdsWriter(node.participant.dds, config)
            node.spin_until(lambda topic=topic: writers[topic].matched)
        with contextlib.suppress(RosError):  # DDS checks the data before it sends them
            writers[topic].write(bytes.fromhex(digits))


def publish_latched(node: Node, *texts: str) -> None:
    """Publish texts on a latched topic before there are subscribers."""
    kind = message_type("std_msgs/msg/String")
    publisher = node.create_publisher(kind.type_name, "robot_description", LATCHED)
    for text in texts:
        publisher.publish(kind(data=text))
    print_ready()
    node.spin_until(parent_has_ended)


def main() -> None:
    # A shell starts background processes with SIGINT ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    kind, domain, *arguments = sys.argv[1:]
    kinds = {
        f.__name__: f
        for f in (
            echo,
            serve,
            send_goal,
            play_motion,
            publish_numbers,
            publish_raw,
            publish_latched,
        )
    }
    network = Network(int(domain), configuration=os.environ.get("PEER_CONFIGURATION", ""))
    with Node(f"peer_{kind}", network=network) as node, contextlib.suppress(KeyboardInterrupt):
        kinds[kind](node, *arguments)


if __name__ == "__main__":
    main()

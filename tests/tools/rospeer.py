"""The other process of the tests of ROS 2: `python rospeer.py KIND DOMAIN ...`.

Each kind says "ready" when it is, and goes on until it is interrupted or its input ends.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time
from typing import Any

from wbc.messages import Template, available, message_type
from wbc.ros import Network, Node, Parameters, Qos, RosError
from wbc.ros.actions import ActionClient, ActionServer, Goal, GoalState
from wbc.ros.endpoints import Writer
from wbc.ros.qos import DEFAULT, LATCHED
from wbc.ros.wire import unread_type

PATIENCE = 20_000_000_000  # ns
ACTION = "nav2_msgs/action/NavigateToPose"


def over() -> bool:
    """Whether the parent has gone."""
    return bool(select.select([sys.stdin], [], [], 0.0)[0]) and not sys.stdin.readline()


def ready() -> None:
    print("ready", flush=True)


def echo(node: Node) -> None:
    """Decodes messages of every type and sends them back, encoded anew.

    Latched, because what is to hear them may be known later than what they came from.
    """
    for name in available():
        topic = name.replace("/", "_").lower()
        back = node.publisher(name, f"back/{topic}", LATCHED)
        node.subscription(name, f"forth/{topic}", lambda m, _, back=back: back.publish(m))
    ready()
    node.spin(over)


def serve(node: Node) -> None:
    """A service, parameters of every kind, and an action without a robot."""
    asked = 0

    def answer(request: Any) -> Any:
        nonlocal asked
        asked += 1
        response = message_type("std_srvs/srv/SetBool_Response")
        return response(success=request.data, message=f"asked {asked} times")

    node.service("std_srvs/srv/SetBool", "switch", answer)
    parameters = Parameters(node)
    parameters.declare("rate", 50.0, "Hz", lowest=1.0, highest=500.0)
    parameters.declare("count", 3, "of things", lowest=0, highest=10)
    parameters.declare("on", True)
    parameters.declare("name", "me")
    parameters.declare("gait.impulse", (0.0, 1.0, 2.0), "N·s", lowest=-10.0, highest=10.0)
    parameters.declare("built", "today", read_only=True)
    goals: list[Goal] = []
    server = ActionServer(
        node,
        ACTION,
        "walk",
        accept=lambda goal: goal.pose.pose.position.x >= 0.0,
        begin=goals.append,
        cancel=lambda _: True,
    )

    def go_on() -> None:
        for goal in [goal for goal in goals if not goal.state.over]:
            if not goal.client_alive:
                print("orphan", flush=True)
                goal.finish(GoalState.ABORTED, server.result_type())
            elif goal.state is GoalState.CANCELING:
                goal.finish(GoalState.CANCELED, server.result_type(error_msg="cancelled"))
            else:
                position = goal.request.pose.pose.position
                goal.feedback(server.feedback_type(distance_remaining=position.x))
                position.x -= 1.0
                if position.x < 0.0:
                    goal.finish(GoalState.SUCCEEDED, server.result_type(error_msg="there"))

    node.timer(0.02, go_on)
    ready()
    node.spin(over)


def pursue(node: Node, x: str, action: str) -> None:
    """Sends a goal that is far away, and waits for it."""
    client = ActionClient(node, ACTION, action)
    request = client.goal_type()
    request.pose.pose.position.x = float(x)
    goal = client.send(request, timeout=20.0)
    print("accepted" if goal.accepted else "rejected", flush=True)
    node.spin(over)


def play(node: Node, text: str) -> None:
    """Has a motion played, and waits for it."""
    client = ActionClient(node, "play_motion2_msgs/action/PlayMotion2", "play_motion2")
    goal = client.send(client.goal_type(motion_name=text), timeout=20.0)
    print("accepted" if goal.accepted else "rejected", flush=True)
    node.spin(over)


def count(node: Node, rate: str, number: str, depth: str = "10") -> None:
    """Publishes numbered joint states of 32 joints at a rate, when somebody listens."""
    kind = message_type("sensor_msgs/msg/JointState")
    zeros = [0.0] * 32
    names = [f"joint_{i}" for i in range(32)]
    template = Template(kind(name=names, position=zeros, velocity=zeros, effort=zeros))
    position = template.view("position")
    publisher = node.publisher(kind.type_name, "joint_states", Qos(depth=int(depth)))
    sent = 0

    def publish() -> None:
        nonlocal sent
        if sent < int(number):
            position[0] = sent
            template.stamp(time.time())
            publisher.publish_bytes(template.data)
            sent += 1

    ready()
    node.spin(lambda: publisher.subscriptions > 0 or over())
    publish()
    publisher.writer.dds.wait_for_acks(PATIENCE)  # the listener may not know us yet
    node.timer(1.0 / float(rate), publish)
    node.spin(over)


def rogue(node: Node, dds_type: str) -> None:
    """Writes whatever bytes it is told: lines of a topic and hexadecimal digits."""
    writers: dict[str, Writer] = {}
    ready()
    for line in sys.stdin:
        topic, digits = line.split()
        if topic not in writers:
            kind = unread_type(dds_type)
            writers[topic] = Writer(node.participant, f"rt/{topic}", kind, DEFAULT, "")
            node.spin(lambda topic=topic: writers[topic].matched)
        with contextlib.suppress(RosError):  # DDS looks at what it is given before it sends it
            writers[topic].write(bytes.fromhex(digits))


def latch(node: Node, *texts: str) -> None:
    """Publishes texts on a latched topic before anybody listens."""
    kind = message_type("std_msgs/msg/String")
    publisher = node.publisher(kind.type_name, "robot_description", Qos(depth=1, latched=True))
    for text in texts:
        publisher.publish(kind(data=text))
    ready()
    node.spin(over)


def main() -> None:
    # A background process of a shell may start with SIGINT ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    kind, domain, *arguments = sys.argv[1:]
    kinds = {f.__name__: f for f in (echo, serve, pursue, play, count, rogue, latch)}
    network = Network(int(domain), configuration=os.environ.get("PEER_CONFIGURATION", ""))
    with Node(f"peer_{kind}", network=network) as node, contextlib.suppress(KeyboardInterrupt):
        kinds[kind](node, *arguments)


if __name__ == "__main__":
    main()

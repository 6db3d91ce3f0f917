"""Measures ROS 2: CPU time per message, load on the loop, and latency between processes.

- publishing: CPU time per message in the thread that publishes and in the whole process (DDS has
  threads of its own), with a subscriber in another process. "Anew" encodes a message object each
  time, "bytes" sends a serialized message, as the robot's node does.
- the loop: CPU time per tick of the copy into shared memory and of receiving commands, at
  500 Hz, with the robot's node publishing everything.
- latency: latency from the stamp in one process to the callback in another, and loss, of joint
  states at 500 Hz on the loopback interface.
- history: joint states at 500 Hz of a robot that stands in real time (`wbc ros2 walk --rate 500`)
  that a subscriber does not get which keeps the last 10, as is usual in ROS 2.
"""

from __future__ import annotations

import argparse
import gc
import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import wbc
from wbc.messages import message_type
from wbc.motions import MotionPlayer
from wbc.ros import Network, Node, QoSProfile
from wbc.ros.bridge import Bridge
from wbc.ros.stamp import stamp_now
from wbc.runtime.stream import TickStream
from wbc.runtime.tick import Tick
from wbc.teleop import CommandHandler
from wbc.topics.link_transforms import LinkPoses, links

Measurement = dict[str, float | str]
JOINTS = 32
RATE = 500.0
KEPT = (10, 10, 10, 100)  #: depths of the subscribers to a robot's joint states


def joint_state() -> Any:
    """Return a joint state of 32 joints."""
    zeros = np.zeros(JOINTS)
    names = [f"leg_left_{i}_joint" for i in range(JOINTS)]
    kind = message_type("sensor_msgs/msg/JointState")
    return kind(name=names, position=zeros, velocity=zeros, effort=zeros)


def transforms() -> Any:
    """Return the transforms of 32 links and of the base."""
    message = message_type("tf2_msgs/msg/TFMessage")()
    kind = message_type("geometry_msgs/msg/TransformStamped")
    for i in range(JOINTS + 1):
        one = kind(child_frame_id=f"leg_left_{i + 1}_link")
        one.header.frame_id = f"leg_left_{i}_link"
        message.transforms.append(one)
    return message


def publishing(domain: int, number: int) -> list[Measurement]:
    """Measure the CPU time of publishing, µs per message."""
    cases: list[tuple[str, Any]] = [
        ("JointState, 32 joints", joint_state()),
        ("TFMessage, 33 transforms", transforms()),
        ("PointStamped", message_type("geometry_msgs/msg/PointStamped")()),
        ("Odometry", message_type("nav_msgs/msg/Odometry")()),
    ]
    rows: list[Measurement] = []
    with Node("publisher", network=Network(domain)) as node:
        for name, message in cases:
            publisher = node.create_publisher(message.type_name, f"case_{len(rows)}")
            peer = other("swallow", domain, publisher.topic_name, message.type_name)
            node.spin_until(
                lambda publisher=publisher: publisher.get_subscription_count() > 0, 20.0
            )
            data = message.encode()

            def from_bytes(publisher: Any = publisher, data: bytes = data) -> None:
                publisher.publish(data)

            def anew(publisher: Any = publisher, message: Any = message) -> None:
                publisher.publish(message)

            rows.append(
                {
                    "what": name,
                    "bytes": len(data),
                    **each("anew", anew, number // 10),
                    **each("bytes", from_bytes, number),
                }
            )
            peer.terminate()
            peer.wait()
    return rows


def each(name: str, action: Callable[[], object], number: int) -> dict[str, float]:
    """Return the CPU time per call of thread and process, µs; minimum of five rounds."""
    own, whole = [], []
    for _ in range(5):
        gc.collect()
        thread, process = time.thread_time(), time.process_time()
        for _ in range(number):
            action()
        own.append((time.thread_time() - thread) / number)
        whole.append((time.process_time() - process) / number)
        time.sleep(0.05)
    return {f"{name}_us": 1e6 * min(own), f"{name}_process_us": 1e6 * min(whole)}


def loop_cost(domain: int, name: str, seconds: float) -> list[Measurement]:
    """Measure the CPU time per tick that ROS 2 takes from a 500 Hz loop, µs."""
    robot = wbc.load(name)
    player = MotionPlayer(robot, dt=1.0 / RATE)
    plant = wbc.sim.Mujoco(robot, dt=1.0 / RATE)
    measurement, estimate = plant.measure(), wbc.Estimate(robot.standing())
    command = player.step(estimate)
    number = int(RATE * seconds)
    records, commands, both = (np.zeros(number) for _ in range(3))
    with (
        CommandHandler(player, plant, owns_clock=False) as handler,
        Bridge(handler, network=Network(domain)) as bridge,
    ):
        handler.begin()
        stream = TickStream(robot)
        bridge.attach(stream)
        bridge.begin(player, plant)
        tick = Tick(0.0, measurement, estimate, command, None, 1e-4, 2e-4)
        due = time.perf_counter()
        gc.collect()
        gc.disable()
        for i in range(number):
            due += 1.0 / RATE
            while time.perf_counter() < due:
                time.sleep(max(due - time.perf_counter() - 3e-4, 0.0))
            start = time.thread_time_ns()
            handler.before_tick(0.0)
            middle = time.thread_time_ns()
            stream.write(tick)
            bridge.observe(tick)
            end = time.thread_time_ns()
            commands[i], records[i], both[i] = middle - start, end - middle, end - start
        gc.enable()
    poses = LinkPoses(robot, [link for link in links(robot) if link.moves])
    kinematics = each("tf", lambda: poses.at(estimate.state.q), 2000)["tf_us"]
    rows = [
        {"what": what, **spread(1e-3 * values)}
        for what, values in (
            ("receiving commands", commands),
            ("record", records),
            ("both", both),
        )
    ]
    rows.append({"what": "all links for tf, in the node's process", "p50_us": kinematics})
    return rows


def spread(values: np.ndarray) -> dict[str, float]:
    """Return median, 99th percentile and maximum, µs."""
    p50, p99, most = np.percentile(values, [50, 99, 100])
    return {"p50_us": float(p50), "p99_us": float(p99), "max_us": float(most)}


def latency(domain: int, seconds: float) -> Measurement:
    """Measure latency and loss of joint states from another process at 500 Hz."""
    number = int(RATE * seconds)
    arrived: list[tuple[int, float]] = []
    with Node("subscriber", network=Network(domain)) as node:

        def hear(message: Any, _: Any) -> None:
            stamp = message.header.stamp
            late = time.time() - stamp.sec - 1e-9 * stamp.nanosec
            arrived.append((int(message.position[0]), late))

        node.create_subscription(
            "sensor_msgs/msg/JointState", "joint_states", hear, QoSProfile(depth=10_000)
        )
        peer = other("stream", domain, str(number))
        node.spin_until(lambda: len(arrived) >= number, 3.0 * seconds + 20.0)
        peer.terminate()
        peer.wait()
    numbers = [i for i, _ in arrived]
    late = 1e6 * np.array([t for _, t in arrived])
    return {
        "sent": number,
        "lost": number - len(set(numbers)),
        "twice": len(numbers) - len(set(numbers)),
        "out_of_order": int((np.diff(numbers) < 0).sum()),
        **spread(late),
    }


def history(domain: int, seconds: float, robot: str) -> list[Measurement]:
    """Count the joint states of a robot at 500 Hz that subscribers of several depths miss."""
    command = ["wbc", "ros2", "walk", "--robot", robot, "--rate", str(RATE), "--sim-time"]
    command += ["--domain", str(domain)]  # stamps of the plant's time tell which are missing
    rows: list[Measurement] = []
    for depth in KEPT:
        stamps: list[float] = []

        def take(message: Any, _: Any, stamps: list[float] = stamps) -> None:
            stamps.append(message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec)

        with (
            subprocess.Popen(
                [sys.executable, "-m", *command], stdout=subprocess.DEVNULL
            ) as process,
            Node("subscriber", network=Network(domain)) as node,
        ):
            node.create_subscription(
                "sensor_msgs/msg/JointState", "joint_states", take, QoSProfile(depth=depth)
            )
            node.spin_until(lambda stamps=stamps: bool(stamps), 60.0)
            node.spin_until(
                lambda stamps=stamps: stamps[-1] - stamps[0] >= seconds, 3.0 * seconds + 20.0
            )
            process.terminate()
        # The first messages come while the two are still finding each other.
        periods = np.diff([stamp for stamp in stamps if stamp > stamps[0] + 1.0])
        sent = round(float(periods.sum()) * RATE)
        rows.append({"keeps": depth, "sent": sent, "lost": sent - len(periods)})
    return rows


def other(kind: str, domain: int, *arguments: str) -> subprocess.Popen[bytes]:
    """Start this script as another process."""
    return subprocess.Popen([sys.executable, __file__, "--as", kind, str(domain), *arguments])


def swallow(domain: str, topic: str, type_name: str) -> None:
    """Receive messages and discard them."""
    dds_name = message_type(type_name).dds_name()
    with Node("swallower", network=Network(int(domain))) as node:
        node.create_raw_subscription(dds_name, topic, lambda _, __: None, QoSProfile(depth=1000))
        node.spin()


def stream(domain: str, number: str) -> None:
    """Publish numbered joint states at 500 Hz."""
    with Node("streamer", network=Network(int(domain))) as node:
        message = joint_state()
        publisher = node.create_publisher("sensor_msgs/msg/JointState", "joint_states")
        node.spin_until(lambda: publisher.get_subscription_count() > 0)
        due = time.perf_counter()
        for i in range(int(number)):
            due += 1.0 / RATE
            while (left := due - time.perf_counter()) > 0.0:
                time.sleep(left)
            message.position[0] = i
            message.header.stamp = stamp_now()
            publisher.publish(message)
        node.spin()


def show(title: str, rows: list[Measurement]) -> None:
    """Print a table."""
    print(f"\n{title}")
    heads = list(dict.fromkeys(key for row in rows for key in row))
    cells = [[text(row.get(head, "")) for head in heads] for row in rows]
    widths = [max(len(line[k]) for line in (heads, *cells)) for k in range(len(heads))]
    for line in (heads, *cells):
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)))


def text(value: float | str) -> str:
    """Return the text of a cell."""
    return f"{value:.1f}" if isinstance(value, float) else str(value)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robot", default="talos", help="of the loop (default: talos)")
    parser.add_argument("--seconds", type=float, default=10.0, help="at 500 Hz (default: 10)")
    parser.add_argument("--messages", type=int, default=2000, help="per round (default: 2000)")
    parser.add_argument("--domain", type=int, default=93, help="DDS domain (default: 93)")
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="also write the figures to this file"
    )
    parser.add_argument("--as", dest="role", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.role:
        kind, *arguments = options.role
        {"swallow": swallow, "stream": stream}[kind](*arguments)
        return
    figures = {
        "publishing": publishing(options.domain, options.messages),
        "loop": loop_cost(options.domain, options.robot, options.seconds),
        "way": [latency(options.domain, options.seconds)],
        "history": history(options.domain, options.seconds, options.robot),
    }
    show("publishing, µs of CPU per message", figures["publishing"])
    show(f"a tick of {options.robot}'s loop at 500 Hz, µs of CPU", figures["loop"])
    show("from one process to another at 500 Hz, µs", figures["way"])
    show("joint states of a robot at 500 Hz, by what a subscriber keeps", figures["history"])
    if options.json is not None:
        options.json.write_text(json.dumps(figures, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()

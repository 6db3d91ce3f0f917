"""Print the position of the right knee from `joint_states`.

Run `wbc ros2 joint-publisher`, `wbc ros2 walk` or any other robot's node in another terminal. The
joints may be in any order; messages without the knee are ignored.
"""

import argparse
import math

from wbc.ros import Node

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--joint", default="right_knee", help="(default: right_knee)")
parser.add_argument("-n", type=int, default=0, help="end after so many positions (default: never)")
options = parser.parse_args()


def position(message, joint):
    """Return the joint's position, rad, or None if the message lacks it."""
    try:
        return float(message.position[message.name.index(joint)])
    except (ValueError, IndexError):  # no such name, or fewer positions than names
        return None


printed = missing = 0


def hear(message, info):
    """Print the knee's position, or warn once that it is missing."""
    global printed, missing
    angle = position(message, options.joint)
    if angle is None:
        missing += 1
        if missing == 1:
            print(f"a message without {options.joint}; it has {', '.join(message.name) or 'none'}")
    elif not options.n or printed < options.n:
        printed += 1
        print(f"{options.joint}: {angle:+.3f} rad = {math.degrees(angle):+.1f}°", flush=True)


with Node("knee_listener") as node:
    node.create_subscription("sensor_msgs/msg/JointState", "joint_states", hear)
    try:
        node.spin_until(lambda: bool(options.n) and printed >= options.n)
    except KeyboardInterrupt:
        print()

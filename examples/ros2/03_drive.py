"""Drive a robot from another ROS 2 node: first by a velocity, then by a goal pose.

Run `wbc ros2 walk` in another terminal.
"""

import argparse

from wbc.messages import message_type
from wbc.ros import Node
from wbc.ros.actions import ActionClient

Twist = message_type("geometry_msgs/msg/Twist")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--speed", type=float, default=0.2, help="m/s (default: 0.2)")
parser.add_argument("--seconds", type=float, default=3.0, help="of walking (default: 3)")
parser.add_argument("--goal", type=float, default=0.5, help="m ahead of it (default: 0.5)")
options = parser.parse_args()

with Node("driver") as node:
    # A velocity times out after half a second, so it must be sent repeatedly.
    velocity = node.create_publisher("geometry_msgs/msg/Twist", "cmd_vel")
    if not node.spin_until(lambda: velocity.get_subscription_count() > 0, timeout_sec=10.0):
        raise SystemExit("no robot listens to /cmd_vel")
    message = Twist()
    message.linear.x = options.speed
    timer = node.create_timer(0.1, lambda: velocity.publish(message))
    node.spin(timeout_sec=options.seconds)
    timer.cancel()

    walk = ActionClient(node, "nav2_msgs/action/NavigateToPose", "navigate_to_pose")
    ahead = walk.goal_type()
    ahead.pose.header.frame_id = "base_link"  # relative to the current pose
    ahead.pose.pose.position.x = options.goal
    goal = walk.send_goal(ahead, lambda f: print(f"{f.distance_remaining:.2f} m to go", flush=True))
    if not goal.accepted:
        raise SystemExit("the goal was rejected")
    goal.wait_for_result(60.0)
    print(goal.status.name.lower(), goal.result.error_msg)

"""Let a robot play a motion from another ROS 2 node.

Run `wbc ros2 walk` in another terminal.
"""

import argparse

from wbc.ros import Node
from wbc.ros.actions import ActionClient

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument(
    "motion", nargs="*", default=["wave"], help="a name, then parameters: squat depth=15 (wave)"
)
parser.add_argument("--wait", type=float, default=60.0, metavar="S", help="for it (default: 60)")
options = parser.parse_args()

with Node("director") as node:
    play = ActionClient(node, "play_motion2_msgs/action/PlayMotion2", "play_motion2")
    if not play.wait_for_server(10.0):
        raise SystemExit("no robot plays motions")
    goal = play.send_goal(play.goal_type(motion_name=" ".join(options.motion)))
    if not goal.accepted:
        raise SystemExit("the goal was rejected")
    if not goal.wait_for_result(options.wait):
        goal.cancel_goal()
        goal.wait_for_result(10.0)
    print(goal.status.name.lower(), goal.result.error)

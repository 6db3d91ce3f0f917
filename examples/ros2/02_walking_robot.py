"""Run a simulated robot as a node of a ROS 2 system, like `wbc ros2 walk`.

`/cmd_vel` drives it. To drive it, run `03_drive.py` or `04_motion.py` in another terminal.
"""

import argparse

import wbc
from wbc.motions import MotionPlayer
from wbc.ros.bridge import Bridge

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--robot", default="simple_humanoid", help="(default: simple_humanoid)")
parser.add_argument("--duration", type=float, default=3.0, help="s (default: 3)")
options = parser.parse_args()

robot = wbc.load(options.robot)
player = MotionPlayer(robot)

with (
    wbc.sim.Mujoco(robot) as plant,
    wbc.teleop.CommandHandler(player, plant) as handler,
    Bridge(handler) as bridge,
):
    report = wbc.teleop.run(handler, options.duration, clients=[bridge])

assert report is not None
print(report.table())

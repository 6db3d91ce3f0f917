"""Drive a robot from the browser."""

import wbc
from wbc.motions import MotionPlayer

robot = wbc.load("simple_humanoid")
player = MotionPlayer(robot)

with (
    wbc.sim.Mujoco(robot) as plant,
    wbc.teleop.CommandHandler(player, plant) as handler,
    wbc.live.Live(handler) as live,  # prints its address
):
    # Sliders, pushes and motions reach the handler through shared memory, before a tick.
    print("motions on the page:", *(motion.name for motion in handler.capabilities.motions))
    report = wbc.teleop.run(handler, duration=3.0, clients=[live])

assert report is not None
print(report.table())

"""A robot driven from the browser."""

import wbc
from wbc.driving import drive
from wbc.live import Live
from wbc.motions import MotionPlayer

robot = wbc.load("simple_humanoid")
player = MotionPlayer(robot)

with wbc.sim.Mujoco(robot) as plant, Live(player, plant) as live:  # prints its address
    # Sliders, pushes and motions reach the loop through shared memory, before a tick.
    print("on the page:", *(motion.name for motion in live.helm.panel.motions))
    report = drive(live, player, plant, duration=5.0)

print(report.table())

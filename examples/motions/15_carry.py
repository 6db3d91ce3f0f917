"""Carry 3 kg that the robot does not know of: it estimates them, counts on them, and walks."""

import wbc
from wbc.motions import Carry, MotionPlayer
from wbc.sim import Mujoco
from wbc.trials import MotionRunner

robot = wbc.load("g1")
player = MotionPlayer(robot, motions=[Carry(mass=3.0, walk=0.2)])
with Mujoco(robot, seed=0) as plant:
    runner = MotionRunner(player)
    report = wbc.run(player, plant, 20.0, before_tick=lambda time: runner(time, plant))
print(report)
print(*player.context.notes, sep="\n")

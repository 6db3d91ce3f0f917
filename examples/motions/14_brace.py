"""Lean on a wall: a hand is a contact like a foot, and the centre of mass may leave the soles.

The hand feels the wall by the torques of its arm. Without the wall the motion gives up.
"""

import wbc
from wbc.motions import Brace, MotionPlayer
from wbc.sim import Mujoco, Wall
from wbc.trials import MotionRunner

robot = wbc.load("g1")
player = MotionPlayer(robot, motions=[Brace(distance=0.3, lean=0.15)])
toes = robot.soles[0].half_length
farthest = 0.0


def tick(time: float) -> None:
    """Let the motion have what it asks for; note how far the true CoM is beyond the toes."""
    global farthest
    runner(time, plant)
    beyond = wbc.Kinematics(robot, plant.ground_truth()).p_com[0] - toes
    farthest = max(farthest, beyond)


with Mujoco(robot, terrain=Wall(distance=0.3), seed=0) as plant:
    runner = MotionRunner(player)
    report = wbc.run(player, plant, 20.0, before_tick=tick)
print(report)
print(*player.context.notes, sep="\n")
print(f"centre of mass up to {1e3 * farthest:.0f} mm beyond the toes")

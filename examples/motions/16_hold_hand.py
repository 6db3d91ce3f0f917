"""Walk to and fro while a hand stays where it is in the world; compare with the true place."""

import numpy as np

import wbc
from wbc.motions import HoldHand, MotionPlayer
from wbc.robot.upper_body import UpperBody
from wbc.sim import Mujoco
from wbc.trials import MotionRunner

robot = wbc.load("g1")
hand = UpperBody.of(robot).arm("left").hand
player = MotionPlayer(robot, motions=[HoldHand(hand="left", speed=0.06)])
places = []


def tick(time: float) -> None:
    """Let the motion go on; while the robot steps, note where the hand truly is."""
    runner(time, plant)
    if player.steps and not player.context.standing:
        places.append(wbc.Kinematics(robot, plant.ground_truth()).frame(hand).translation.copy())


with Mujoco(robot, seed=0) as plant:
    runner = MotionRunner(player)
    report = wbc.run(player, plant, 30.0, before_tick=tick)
print(report)
print(*player.context.notes, sep="\n")
if places:
    off = np.linalg.norm(places - np.mean(places, axis=0), axis=1)
    print(
        f"in truth: rms {1e3 * np.sqrt(np.mean(off**2)):.0f} mm, at most {1e3 * off.max():.0f} mm"
    )

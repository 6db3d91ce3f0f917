"""Motions in a row, one blended over into another, one broken off: no torque jumps.

The player is a controller like the walker: it runs in `wbc.run`, and walks by its velocity.
"""

import wbc
from wbc.motions import Bow, MotionPlayer, Squat, Sway

robot = wbc.load("simple_humanoid")
player = MotionPlayer(robot, motions=[Sway(), Bow()])
orders = [
    (3.0, lambda: player.blend(Squat(times=3))),  # at once, from wherever the body is
    (5.5, player.interrupt),  # back to standing
]


def direct(time: float) -> None:
    """Change one's mind twice."""
    if orders and time >= orders[0][0]:
        orders.pop(0)[1]()
        print(f"{time:.1f} s: {player.playing.name if player.playing else 'stand again'}")


with wbc.sim.Mujoco(robot) as plant:
    report = wbc.run(player, plant, duration=7.5, before_tick=direct)
print(report.table())
print("it stands as before:", player.context.at_home)

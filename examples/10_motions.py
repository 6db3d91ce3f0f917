"""Play motions in sequence, blend from one to the next and abort one, without torque jumps.

The motion player is a controller like the walker: it runs in `wbc.run` and has a walking velocity.
"""

import wbc
from wbc.motions import Bow, MotionPlayer, Squat, Sway

robot = wbc.load("simple_humanoid")
player = MotionPlayer(robot, motions=[Sway(), Bow()])
orders = [
    (3.0, lambda: player.blend(Squat(times=3))),  # at once, from the current posture
    (5.5, player.interrupt),  # back to standing
]


def direct(time: float) -> None:
    """Request another motion, then abort it."""
    if orders and time >= orders[0][0]:
        orders.pop(0)[1]()
        print(f"{time:.1f} s: {player.playing.name if player.playing else 'standing'}")


with wbc.sim.Mujoco(robot) as plant:
    report = wbc.run(player, plant, duration=7.5, before_tick=direct)
print(report.table())
print("stands as before:", player.context.at_home)

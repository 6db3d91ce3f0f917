"""Motions in a row, one blended over into another, one broken off: no torque jumps.

The performer is a controller like the walker: it runs in `wbc.run`, and walks by its velocity.
"""

import wbc
from wbc.motions import Bow, Performer, Squat, Sway

robot = wbc.load("simple_humanoid")
performer = Performer(robot, motions=[Sway(), Bow()])
orders = [
    (3.0, lambda: performer.blend(Squat(times=3))),  # at once, from wherever the body is
    (5.5, performer.interrupt),  # back to standing
]


def direct(time: float) -> None:
    """Change one's mind twice."""
    if orders and time >= orders[0][0]:
        orders.pop(0)[1]()
        print(f"{time:.1f} s: {performer.playing.name if performer.playing else 'stand again'}")


with wbc.sim.Mujoco(robot) as plant:
    report = wbc.run(performer, plant, duration=7.5, before_tick=direct)
print(report.table())
print("it stands as before:", performer.body.at_home)

"""Walk at a commanded velocity, which may change at any tick."""

import wbc

robot = wbc.load("talos")
walker = wbc.Walker(robot, dt=0.002)


def steer(time: float) -> None:
    """Command a straight walk, then a curve to the left, then a stop."""
    if time < 1.0:
        walker.velocity = (0.0, 0.0, 0.0)
    elif time < 3.5:
        walker.velocity = (0.3, 0.0, 0.0)
    elif time < 5.5:
        walker.velocity = (0.2, 0.0, 0.3)
    else:
        walker.velocity = (0.0, 0.0, 0.0)


with wbc.sim.Mujoco(robot) as plant:
    report = wbc.run(walker, plant, duration=7.0, before_tick=steer)

print(report.table())

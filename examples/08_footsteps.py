"""Walk over a given list of footsteps, for example stepping stones chosen by a planner."""

import numpy as np

import wbc

robot = wbc.load("talos")
walker = wbc.Walker(robot)
half_width = 0.5 * walker.gait.step_width

steps, forward = [], 0.0
for k, length in enumerate((0.15, 0.25, 0.1, 0.2, 0.2, 0.0)):
    forward += length
    side, sign = (("left", 1.0), ("right", -1.0))[k % 2]
    steps.append(wbc.Footstep(side, np.array([forward, sign * half_width, 0.0]), yaw=0.0))

walker.follow(steps)
with wbc.sim.Mujoco(robot) as plant:
    report = wbc.run(walker, plant, duration=6.5)
    landed = wbc.Kinematics(robot, plant.ground_truth())

print(report.table())
for sole, step in zip(("left_sole", "right_sole"), steps[-2:], strict=True):
    error = landed.frame(sole).translation[:2] - step.position[:2]
    print(f"{sole} is {1e3 * np.linalg.norm(error):.0f} mm from its last footstep")

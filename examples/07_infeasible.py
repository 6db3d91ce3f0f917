"""Set an infeasible task: the controller explains which rows of the QP are in conflict.

The command nevertheless stays finite and safe.
"""

import numpy as np

import wbc

robot = wbc.load("talos")
state = robot.standing()
controller = wbc.WholeBodyController(robot)
controller.add(wbc.PostureTask(robot))
controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
print("standing:", controller.step(state).status.value)

# Priority 0 is exact. No contact force can pull the feet towards the ground.
lift = controller.add(wbc.ComTask(priority=0))
lift.acceleration = np.array([0.0, 0.0, -20.0])  # m/s², faster than it can fall
command = controller.step(state)
print("pulled down:", command.status.value)
print(" ", command.explanation)
print("torques are finite:", np.isfinite(command.tau).all())

lift.acceleration = np.zeros(3)
print("without the task:", controller.step(state).status.value)

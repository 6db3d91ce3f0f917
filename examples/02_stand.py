"""Stand and sway with the whole-body controller, given tasks and contacts.

The control loop is written out: measure, estimate, control, act.
"""

import numpy as np

import wbc

DURATION = 4.0  # s
SWAY = 0.03  # m to either side

robot = wbc.load("talos")
controller = wbc.WholeBodyController(robot, dt=0.002)
com = controller.add(wbc.ComTask(weight=1000.0, kp=40.0))
controller.add(wbc.OrientationTask(robot.torso, weight=20.0, kp=80.0))
controller.add(wbc.PostureTask(robot, weight=0.3, kp=60.0))
controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])

with wbc.sim.Mujoco(robot, dt=0.002) as plant:
    estimator = wbc.Estimator(robot, plant.dt)
    estimator.reset(robot.standing())
    home = wbc.Kinematics(robot, robot.standing()).p_com.copy()
    way = []
    while plant.time < DURATION:
        estimate = estimator.update(plant.measure())
        com.target = home + np.array([0.0, SWAY * np.sin(np.pi * plant.time), 0.0])
        command = controller.step(estimate.state)
        plant.step(command)
        assert controller.kinematics is not None
        way.append(controller.kinematics.p_com[1] - home[1])

print(f"swayed between {1e3 * min(way):+.0f} and {1e3 * max(way):+.0f} mm")
for name, wrench in command.wrenches.items():
    print(f"{name} carries {wrench[2]:.0f} N")

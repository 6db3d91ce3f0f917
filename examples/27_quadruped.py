"""Stand, sway and squat on four feet, with a point contact on each.

`wbc.Walker` walks on two feet; a quadruped stands on the whole-body controller. Two of its feet are
stated as the robot's soles, which place its nominal posture.
"""

import numpy as np

import wbc

DURATION = 3.0  # s
SWAY, SQUAT = 0.02, 0.02  # m

robot = wbc.load("solo12", left_foot="FL_FOOT", right_foot="FR_FOOT")
feet = [*(sole.name for sole in robot.soles), "HL_FOOT", "HR_FOOT"]
controller = wbc.WholeBodyController(robot, dt=0.002)
com = controller.add(wbc.ComTask(weight=1000.0, kp=100.0))
controller.add(wbc.OrientationTask(robot.base, weight=100.0, kp=100.0))
controller.add(wbc.PostureTask(robot, weight=0.1, kp=50.0))
controller.set_contacts([wbc.PointContact(foot) for foot in feet])

with wbc.sim.Mujoco(robot, dt=0.002, ground_truth=True) as plant:
    estimator = wbc.GroundTruthEstimator(robot)
    estimator.reset(robot.standing())
    home = wbc.Kinematics(robot, robot.standing()).p_com.copy()
    way = []
    while plant.time < DURATION:
        estimate = estimator.update(plant.measure())
        phase = np.pi * plant.time
        com.target = home + np.array(
            [0.0, SWAY * np.sin(phase), -0.5 * SQUAT * (1.0 - np.cos(phase))]
        )
        command = controller.step(estimate.state)
        assert command.status is wbc.Status.OK, command.explanation
        plant.step(command)
        assert controller.kinematics is not None
        way.append(controller.kinematics.p_com - home)

low, high = 1e3 * np.min(way, axis=0), 1e3 * np.max(way, axis=0)
print(f"swayed between {low[1]:+.0f} and {high[1]:+.0f} mm, squatted by {-low[2]:.0f} mm")
for name, wrench in command.wrenches.items():
    print(f"{name} carries {wrench[2]:.1f} N")

"""Load a robot and compute frames, Jacobians, centre of mass and dynamics.

Each quantity of a state is computed once, on first access, and then cached.
"""

import numpy as np

import wbc

robot = wbc.load("talos")
state = robot.standing()  # soles on z = 0, midpoint at the origin
kin = wbc.Kinematics(robot, state)

np.set_printoptions(precision=3, suppress=True)
print(f"{robot.name}: {robot.na} joints, {robot.mass:.1f} kg")
print("left sole at        ", kin.frame("left_sole").translation, "m")
print("centre of mass at   ", kin.p_com, "m")

# How fast would the left sole move if only the knee moved, with 1 rad/s?
knee = robot.joint_index("leg_left_4_joint")
print("knee moves the sole ", kin.jacobian("left_sole")[:3, 6 + knee], "m/s per rad/s")

# Without torques and contacts the CoM falls with g and the angular momentum is constant.
acceleration = np.linalg.solve(kin.mass_matrix, -kin.bias_forces)
print("free fall, CoM at   ", kin.J_com @ acceleration + kin.bias_com, "m/s²")
print("angular momentum    ", kin.centroidal_momentum[3:], "N·m·s")

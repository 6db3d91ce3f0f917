"""Inverse kinematics of an arm: follow a target step by step, and find a posture at once."""

import numpy as np
import pinocchio as pin

import wbc

robot = wbc.load_fixed_base("panda")
ik = wbc.InverseKinematics(robot)
hand = ik.add(wbc.FrameTask("panda_hand"))
ik.add(wbc.PostureTask(robot, weight=0.01))
print(ik)

# Velocities: the hand follows a circle. A target that is left out is the pose at the start.
q, dt = robot.q_nominal.copy(), 0.01
ik.step(q, dt)
center = hand.target
for k in range(201):
    angle = np.pi * k * dt
    offset = 0.1 * np.array([0.0, np.sin(angle), 1.0 - np.cos(angle)])
    hand.target = pin.SE3(center.rotation, center.translation + offset)
    hand.velocity[1:3] = 0.1 * np.pi * np.array([np.cos(angle), np.sin(angle)])
    q = pin.integrate(robot.model, q, dt * ik.step(q, dt))
    if k % 50 == 0:
        off = np.linalg.norm(
            hand.target.translation - ik.kinematics.frame("panda_hand").translation
        )
        print(f"after {k * dt:.1f} s the hand is {1e3 * off:.1f} mm from its target")

# A posture: the same tasks, searched for with restarts. What cannot be reached is explained.
hand.target = pin.SE3(pin.rpy.rpyToMatrix(np.pi, 0.0, 0.5), np.array([0.3, -0.4, 0.2]))
found = ik.reach(q)
print(f"reached: {found.reached}, joints {found.q[7:].round(2)} rad")
hand.target = pin.SE3(hand.target.rotation, np.array([0.6, -0.6, 0.2]))
print(ik.reach(q).explanation)

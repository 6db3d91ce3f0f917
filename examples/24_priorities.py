"""Strict priorities: a hand that reaches too far does not pull the robot over.

With weights the hand moves the centre of mass (CoM) away from its place between the feet. On a
level of its own, below that of the CoM, it only gets what the CoM leaves to it.
"""

import numpy as np
import pinocchio as pin

import wbc

robot = wbc.load("talos")
hand = "gripper_left_base_link"


def reach(priorities):
    """Reach 1 m forwards for 2 s; return by how much the CoM and the hand have moved."""
    of_com, of_hand, of_posture = priorities
    controller = wbc.WholeBodyController(robot)
    controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
    controller.add(wbc.ComTask(priority=of_com))
    controller.add(wbc.PostureTask(robot, priority=of_posture))
    state = robot.standing()
    start = wbc.Kinematics(robot, state)
    target = start.frame(hand).translation + np.array([1.0, 0.0, 0.0])
    controller.add(wbc.PositionTask(hand, target, kp=10.0, priority=of_hand))
    for _ in range(1000):
        command = controller.step(state)
        v = state.v + controller.dt * command.acceleration
        state = wbc.State(pin.integrate(robot.model, state.q, controller.dt * v), v)
    end = wbc.Kinematics(robot, state)
    moved = end.frame(hand).translation - start.frame(hand).translation
    return np.linalg.norm(end.p_com - start.p_com), moved[0], command.status


for name, priorities in (("weighted", (1, 1, 1)), ("three levels", (1, 2, 3))):
    com, forwards, status = reach(priorities)
    print(f"{name}: CoM moved {1e3 * com:.1f} mm, hand {forwards:.2f} m forwards ({status.value})")

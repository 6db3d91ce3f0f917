"""Self-collision: both hands of G1 are told to go to the same place, and stop before they touch."""

import numpy as np
import pinocchio as pin

import wbc
from wbc.limits import SelfCollisionLimit
from wbc.robot.upper_body import UpperBody

robot = wbc.load("g1")
collision = SelfCollisionLimit(robot, margin=0.01)
print(collision.pairs.report())

arms = UpperBody.of(robot).both_arms()
joints = [robot.joint_names[joint] for arm in arms for joint in arm.joints]
ik = wbc.InverseKinematics(
    robot,
    joints=joints,
    limits=[wbc.JointPositionLimit(robot), wbc.JointVelocityLimit(robot), collision],
)
for arm in arms:
    ik.add(wbc.PositionTask(arm.hand, (0.3, 0.0, 0.9)))
ik.add(wbc.PostureTask(robot, weight=0.01))

# Step by step: a barrier, h = distance − margin ≥ 0, keeps them apart.
q, dt = robot.q_nominal.copy(), 0.01
for k in range(301):
    q = pin.integrate(robot.model, q, dt * ik.step(q, dt))
    if k % 100 == 0:
        distance, pair = collision.pairs.least_distance(q)
        name = collision.pairs.pair_name(pair)
        print(f"after {k * dt:.0f} s: {name} {1e3 * distance:.0f} mm apart")

# At once: the search says which bodies are in the way.
print(ik.reach(q, restarts=3).explanation)

# The same limit holds in the controller, on accelerations.
controller = wbc.WholeBodyController(robot)
controller.set_limits([*controller.limits, collision])
controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
controller.add(wbc.ComTask())
controller.add(wbc.PostureTask(robot))
for arm in arms:
    controller.add(wbc.PositionTask(arm.hand, (0.3, 0.0, 0.9), weight=30.0, kp=30.0))
state, least = robot.standing(), np.inf
for _ in range(600):
    command = controller.step(state)
    v = state.v + controller.dt * command.acceleration
    state = wbc.State(pin.integrate(robot.model, state.q, controller.dt * v), v)
    least = min(least, min(collision.distances.values()))
print(f"with torques: {command.status.value}, never less than {1e3 * least:.0f} mm apart")

"""Write your own task, rows `A v̇ = b`. This one controls the distance between two hands."""

import numpy as np
import pinocchio as pin

import wbc


class DistanceTask(wbc.Task):
    """Controls the distance d of two frames: `d̈ = −kd ḋ + kp (target − d)`, d in m.

    With n the unit vector from one frame to the other and v their relative velocity,
    `d̈ = nᵀ (J₁ − J₂) v̇ + nᵀ (J̇₁ − J̇₂) v + (|v|² − ḋ²)/d`.
    """

    unit = "m/s²"

    def __init__(self, one, other, target, weight=50.0, kp=100.0):
        super().__init__("hand distance", 1, weight, kp, None, priority=1)
        self.frames = (one, other)
        self.target = target

    def write(self, kin, A, b):
        """Write the row of the current state."""
        one, other = (kin.motion(frame) for frame in self.frames)
        apart = one.position - other.position
        distance = np.linalg.norm(apart)
        n = apart / distance
        v = (one.velocity - other.velocity)[:3]
        rate = n @ v
        bias = n @ (one.bias - other.bias)[:3] + (v @ v - rate**2) / distance
        A[0] = n @ (one.jacobian - other.jacobian)[:3]
        b[:] = -self.kd * rate + self.kp * (self.target - distance) - bias


robot = wbc.load("simple_humanoid")
controller = wbc.WholeBodyController(robot)
controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
controller.add(wbc.ComTask())
controller.add(wbc.PostureTask(robot, weight=0.1))
task = controller.add(DistanceTask("left_hand", "right_hand", target=0.3))
print(task)

state, dt = robot.standing(), controller.dt
for tick in range(1001):
    command = controller.step(state)
    if tick % 250 == 0:
        left, right = (controller.kinematics.frame(f"{s}_hand") for s in ("left", "right"))
        gap = np.linalg.norm(left.translation - right.translation)
        print(f"after {tick * dt:.1f} s the hands are {gap:.3f} m apart")
    v = state.v + dt * command.acceleration
    state = wbc.State(pin.integrate(robot.model, state.q, dt * v), v)

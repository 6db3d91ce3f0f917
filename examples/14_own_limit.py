"""Write your own limit, rows `lower ≤ A v̇ ≤ upper`. This one keeps a hand above a table.

It is a control barrier function: the height h above the table obeys `ḧ + k₁ ḣ + k₂ h ≥ 0`, so that
it never becomes negative, whatever the tasks demand (Ames et al., Control barrier functions: theory
and applications, ECC 2019).
"""

import numpy as np
import pinocchio as pin

import wbc


class TableLimit(wbc.Limit):
    """Keeps a frame above a height, m."""

    def __init__(self, frame, height, k1=20.0, k2=100.0):
        super().__init__("table", 1, unit="m/s²", labels=(frame,))
        self.frame = frame
        self.height = height
        self.k1, self.k2 = k1, k2  # 1/s, 1/s²

    def write(self, kin, rows):
        """Write the row of the current state: `J_z v̇ ≥ −J̇_z v − k₁ ḣ − k₂ h`."""
        hand = kin.motion(self.frame)
        h, rate = hand.position[2] - self.height, hand.velocity[2]
        rows.A[0] = hand.jacobian[2]
        rows.lower[0] = -hand.bias[2] - self.k1 * rate - self.k2 * h


robot = wbc.load("simple_humanoid")
state = robot.standing()
start = wbc.Kinematics(robot, state).frame("right_hand").translation
table = start[2] - 0.05

controller = wbc.WholeBodyController(robot)
controller.set_limits((*controller.limits, TableLimit("right_hand", table)))
controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
controller.add(wbc.ComTask())
controller.add(wbc.PostureTask(robot, weight=0.1))
controller.add(wbc.PositionTask("right_hand", start - np.array([0.0, 0.0, 0.2])))

lowest, dt = np.inf, controller.dt
for _ in range(1000):
    command = controller.step(state)
    lowest = min(lowest, controller.kinematics.frame("right_hand").translation[2] - table)
    v = state.v + dt * command.acceleration
    state = wbc.State(pin.integrate(robot.model, state.q, dt * v), v)
print(f"target 150 mm below the table; the hand stayed {1e3 * lowest:.1f} mm above it")

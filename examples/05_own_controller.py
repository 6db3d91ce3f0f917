"""Write your own controller for `wbc.run`: a class with `reset(state)` and `step(estimate)`.

This one has no balance control: it holds the initial posture by joint stiffness and damping plus
the torques that support the weight.
"""

import numpy as np

import wbc


class HoldPosture:
    """Joint stiffness and damping plus static torques."""

    def __init__(self, robot, stiffness=20.0, damping=0.6):
        self.robot = robot
        self.kp = stiffness * robot.tau_max  # N·m/rad
        self.kd = damping * robot.tau_max  # N·m·s/rad

    def reset(self, state):
        """Hold the current posture from now on."""
        kin = wbc.Kinematics(self.robot, state)
        self.q = state.q[7:].copy()
        # The smallest foot wrenches that support the weight at rest, and the corresponding torques.
        J = np.vstack([kin.jacobian(sole.name) for sole in self.robot.soles])
        loads = np.linalg.lstsq(J[:, :6].T, kin.bias_forces[:6], rcond=None)[0]
        self.tau = kin.bias_forces[6:] - J[:, 6:].T @ loads

    def step(self, estimate):
        """Return the command of one tick."""
        state = estimate.state
        tau = self.tau + self.kp * (self.q - state.q[7:]) - self.kd * state.v[6:]
        tau = np.clip(tau, -self.robot.tau_max, self.robot.tau_max)
        still = np.zeros(self.robot.na)
        return wbc.Command(tau, np.zeros(self.robot.nv), {}, self.q, still)


robot = wbc.load("simple_humanoid")
with wbc.sim.Mujoco(robot) as plant:
    plant.schedule_push(1.0, [3.0, 0.0, 0.0])  # N·s
    report = wbc.run(HoldPosture(robot), plant, duration=3.0)
print(report.table())

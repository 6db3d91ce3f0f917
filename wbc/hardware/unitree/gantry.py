"""The gantry in which the stand-in robot hangs until it stands by itself."""

from __future__ import annotations

import math

import numpy as np

from wbc.robot import Robot
from wbc.servo import ServoCommand
from wbc.sim import Mujoco

_FREQUENCY, _DAMPING_RATIO = 3.0, 1.0  # Hz, of the robot in the gantry
_LOWER_AFTER = 3.0  # s of a held posture
_LOWERING_TIME = 1.0  # s
_RELEASE_TIME = 0.5  # s of feed-forward torques in which its rope gets slack


class Gantry:
    """A spring and damper between the base and the pose in which the robot stands.

    Args:
        robot: the robot.

    Attributes:
        lift: height above the standing pose at the start, m.
        released: whether it has let go.
    """

    def __init__(self, robot: Robot) -> None:
        omega = 2.0 * math.pi * _FREQUENCY
        self.lift = 0.08
        self._stiffness, self._damping = omega**2, 2.0 * _DAMPING_RATIO * omega
        self._mass, self._weight = robot.mass, robot.weight
        self._inertia = robot.mass * 0.1  # kg·m², that of a humanoid about its base, roughly
        self._base = robot.q_nominal[:3].copy()
        self._held_since = self._carried_since = math.inf
        self.released = False

    def apply(self, plant: Mujoco, command: ServoCommand) -> None:
        """Set the force on the base for the next period."""
        now, force = plant.time, plant.data.qfrc_applied
        if command.kp.any() and self._held_since == math.inf:
            self._held_since = now
        # The safety layer's limits alone give single joints a torque.
        commanded = np.count_nonzero(command.tau) > 0.5 * command.tau.size
        if commanded and self._carried_since == math.inf:
            self._carried_since = now
        if self.released:
            return
        slack = (now - self._carried_since) / _RELEASE_TIME
        tension = 1.0 - min(max(slack, 0.0), 1.0)
        if tension == 0.0:
            self.released = True
            force[:6] = plant.model.dof_damping[:6] = 0.0
            return
        # MuJoCo integrates its own damping implicitly: it holds a pelvis between limp joints.
        plant.model.dof_damping[:3] = tension * self._mass * self._damping
        plant.model.dof_damping[3:6] = tension * self._inertia * self._damping
        lowered = (now - self._held_since - _LOWER_AFTER) / _LOWERING_TIME
        share = 1.0 - min(max(lowered, 0.0), 1.0)
        goal = self._base + np.array([0.0, 0.0, self.lift * share])
        state = plant.ground_truth()
        force[:3] = self._mass * self._stiffness * (goal - state.q[:3])
        force[2] += self._weight * share  # in the air it carries the weight; later the feet do
        rotation_vector = 2.0 * state.q[3:6] * np.sign(state.q[6])  # of a small rotation
        force[3:6] = -self._inertia * self._stiffness * rotation_vector
        force[:6] *= tension

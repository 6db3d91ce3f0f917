"""The robot's configurations while its centre of mass goes straight up and down."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from wbc.motions.jumping.profile import Moment
from wbc.robot import Robot
from wbc.robot.statics import smallest_wrenches

_LEVER = 0.05  # m, makes moments comparable to forces when both soles share the load


@dataclass(frozen=True)
class JumpPath:
    """Configurations q(z) over the CoM's height z above the soles, and their dynamics.

    On the way both soles stay flat where they stand in the nominal posture, the CoM is above
    the middle of the soles, and the body has no angular momentum about the CoM,
    `A_L(q) dq/dz = 0`: what the legs have, trunk and arms take up. Whoever goes along it, at
    any pace, takes off without spin. And without spin the same configurations are those of
    the flight too, z then being the CoM's height above the soles in the air.

    With `v = q' ż` and `v̇ = q' z̈ + q'' ż²` the generalised forces are linear in (z̈, ż²):

        M v̇ + h = a(z) z̈ + b(z) ż² + c(z)

    (path parameterisation: Bobrow, Dubowsky and Gibson, Time-optimal control of robotic
    manipulators along specified paths, IJRR 1985).

    Attributes:
        robot: the robot.
        height: (n,) z, ascending, m; the trunk is upright at the last.
        q: (n, nq).
        tangent: (n, nv) q', per m, base in the base's axes.
        bend: (n, nv) q'', per m².
        lean: (n, 2) pitch of torso and base about the world's y axis, 0 when standing, rad.
        force: (n, nv, 3) the columns a, b, c.
    """

    robot: Robot
    height: np.ndarray
    q: np.ndarray
    tangent: np.ndarray
    bend: np.ndarray
    lean: np.ndarray
    force: np.ndarray

    @property
    def top(self) -> float:
        """The greatest height, m."""
        return float(self.height[-1])

    @cached_property
    def _lean_rate(self) -> np.ndarray:
        return np.asarray(np.gradient(self.lean, self.height, axis=0, edge_order=2))

    @cached_property
    def _lean_bend(self) -> np.ndarray:
        return np.asarray(np.gradient(self._lean_rate, self.height, axis=0))

    @cached_property
    def stance(self) -> np.ndarray:
        """(n, na, 3) joint torques of (z̈, ż², 1) with both soles on the ground.

        Of the wrenches that the base rows ask for, the smallest.
        """
        model, data = self.robot.model, self.robot.model.createData()
        torque = np.empty((len(self.height), self.robot.na, 3))
        for k, q in enumerate(self.q):
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacements(model, data)
            J = np.vstack(
                [pin.getFrameJacobian(model, data, s.frame_id, pin.LOCAL) for s in self.robot.soles]
            )
            wrenches = smallest_wrenches(J, self.force[k, :6], _LEVER)
            torque[k] = self.force[k, 6:] - J[:, 6:].T @ wrenches
        return torque

    @cached_property
    def flight(self) -> np.ndarray:
        """(n, na, 3) joint torques of (z̈, ż², 1) in the air.

        In free fall the soles accelerate by −g − z̈: to the rest of the robot that is a
        gravity of −z̈ instead of g.
        """
        a, b, c = np.moveaxis(self.force[:, 6:], -1, 0)
        return np.stack((a - c / gravity_of(self.robot), b, np.zeros_like(c)), axis=-1)

    def torque(
        self, table: np.ndarray, z: np.ndarray, rate: np.ndarray, acceleration: np.ndarray
    ) -> np.ndarray:
        """(k, na) joint torques by `stance` or `flight` at (k,) z, ż and z̈, N·m."""
        T = self._at(table, z)
        moment = np.stack((acceleration, rate**2, np.ones_like(z)), axis=-1)
        return np.asarray(np.einsum("kjc,kc->kj", T, moment))

    def joint_velocity(self, z: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """(k, na) joint velocities, rad/s."""
        return np.asarray(self._at(self.tangent[:, 6:], z) * rate[:, None])

    def posture(self, moment: Moment) -> np.ndarray:
        """(3, na) joint positions, velocities and accelerations at (z, ż, z̈)."""
        z, rate, acceleration = moment
        at = np.array([z])
        q, tangent, bend = (
            self._at(table, at)[0]
            for table in (self.q[:, 7:], self.tangent[:, 6:], self.bend[:, 6:])
        )
        return np.array([q, tangent * rate, tangent * acceleration + bend * rate * rate])

    def attitude(self, moment: Moment) -> np.ndarray:
        """(3, 2) lean of torso and base, its rate and acceleration at (z, ż, z̈); rad, s."""
        z, rate, acceleration = moment
        at = np.array([z])
        lean, slope, bend = (
            self._at(table, at)[0] for table in (self.lean, self._lean_rate, self._lean_bend)
        )
        return np.array([lean, slope * rate, slope * acceleration + bend * rate * rate])

    def _at(self, table: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Linear interpolation of (n, …) at heights (k,); the ends are kept beyond."""
        x = np.interp(z, self.height, np.arange(len(self.height), dtype=float))
        below = np.minimum(x.astype(int), len(self.height) - 2)
        share = (x - below).reshape(-1, *[1] * (table.ndim - 1))
        return np.asarray(table[below] * (1.0 - share) + table[below + 1] * share)


def gravity_of(robot: Robot) -> float:
    """m/s², downward."""
    return -float(robot.model.gravity.linear[2])

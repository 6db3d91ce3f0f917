"""The robot's configurations while its centre of mass moves straight up and down."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from wbc.motions.jumping.profile import HeightState
from wbc.robot import Robot
from wbc.robot.statics import smallest_wrenches

_LEVER = 0.05  # m, makes moments comparable to forces when both soles share the load


@dataclass(frozen=True)
class JumpPath:
    """Configurations q(z) over the CoM's height z above the soles, and their dynamics.

    Along the path both soles stay flat where they stand in the nominal posture, the CoM is above
    the middle of the soles, and the robot has no angular momentum about the CoM,
    `A_L(q) dq/dz = 0`: trunk and arms compensate that of the legs. A motion along the path takes
    off without spin at any pace. Without spin the same configurations are those of the flight,
    z then being the CoM's height above the soles in the air.

    With `v = q' ż` and `v̇ = q' z̈ + q'' ż²` the generalised forces are linear in (z̈, ż²):

        M v̇ + h = a(z) z̈ + b(z) ż² + c(z)

    (path parameterisation: Bobrow, Dubowsky and Gibson, Time-optimal control of robotic
    manipulators along specified paths, IJRR 1985).

    Attributes:
        robot: the robot.
        height: (n,) z, ascending, m; the trunk is upright at the last.
        q: (n, nq) configurations.
        tangent: (n, nv) q', per m, the base's part in the base's axes.
        curvature: (n, nv) q'', per m².
        pitch: (n, 2) pitch of torso and base about the world's y axis, 0 when standing, rad.
        force: (n, nv, 3) the columns a, b, c.
    """

    robot: Robot
    height: np.ndarray
    q: np.ndarray
    tangent: np.ndarray
    curvature: np.ndarray
    pitch: np.ndarray
    force: np.ndarray

    def __repr__(self) -> str:
        low, high = self.height[[0, -1]].tolist()
        return f"JumpPath({self.robot.name}, CoM from {low:.3f} to {high:.3f} m)"

    @property
    def top(self) -> float:
        """Greatest height of the CoM above the soles, m."""
        return float(self.height[-1])

    @cached_property
    def _pitch_rate(self) -> np.ndarray:
        return np.asarray(np.gradient(self.pitch, self.height, axis=0, edge_order=2))

    @cached_property
    def _pitch_curvature(self) -> np.ndarray:
        return np.asarray(np.gradient(self._pitch_rate, self.height, axis=0))

    @cached_property
    def stance(self) -> np.ndarray:
        """(n, na, 3) coefficients of (z̈, ż², 1) in the joint torques, both soles on the ground.

        The contact wrenches are the smallest that the base needs.
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
        """(n, na, 3) coefficients of (z̈, ż², 1) in the joint torques, in the air.

        In free fall the soles accelerate by −g − z̈: for the rest of the robot that is a
        gravity of −z̈ instead of g.
        """
        a, b, c = np.moveaxis(self.force[:, 6:], -1, 0)
        return np.stack((a - c / self.robot.gravity, b, np.zeros_like(c)), axis=-1)

    def torque(
        self, table: np.ndarray, z: np.ndarray, rate: np.ndarray, acceleration: np.ndarray
    ) -> np.ndarray:
        """Return the joint torques (k, na), N·m, by `stance` or `flight`, at (k,) z, ż and z̈."""
        coefficients = self._at(table, z)
        variables = np.stack((acceleration, rate**2, np.ones_like(z)), axis=-1)
        return np.asarray(np.einsum("kjc,kc->kj", coefficients, variables))

    def joint_velocity(self, z: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Return the joint velocities (k, na), rad/s, at (k,) z and ż."""
        return np.asarray(self._at(self.tangent[:, 6:], z) * rate[:, None])

    def posture(self, height: HeightState) -> np.ndarray:
        """Return joint positions, velocities and accelerations at (z, ż, z̈), (3, na)."""
        z, rate, acceleration = height
        at = np.array([z])
        q, tangent, curvature = (
            self._at(table, at)[0]
            for table in (self.q[:, 7:], self.tangent[:, 6:], self.curvature[:, 6:])
        )
        return np.array([q, tangent * rate, tangent * acceleration + curvature * rate * rate])

    def trunk_pitch(self, height: HeightState) -> np.ndarray:
        """Return pitch, rate and acceleration of torso and base at (z, ż, z̈), (3, 2); rad, s."""
        z, rate, acceleration = height
        at = np.array([z])
        pitch, slope, curvature = (
            self._at(table, at)[0]
            for table in (self.pitch, self._pitch_rate, self._pitch_curvature)
        )
        return np.array([pitch, slope * rate, slope * acceleration + curvature * rate * rate])

    def _at(self, table: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Interpolate a table (n, …) linearly at heights (k,), constant beyond its ends."""
        x = np.interp(z, self.height, np.arange(len(self.height), dtype=float))
        below = np.minimum(x.astype(int), len(self.height) - 2)
        share = (x - below).reshape(-1, *[1] * (table.ndim - 1))
        return np.asarray(table[below] * (1.0 - share) + table[below + 1] * share)

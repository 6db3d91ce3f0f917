"""Kinematics of a robot at rest: what inverse kinematics needs, and dynamics only when asked."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from wbc.kinematics import Kinematics
from wbc.robot import RobotModel
from wbc.state import State


class ConfigurationKinematics(Kinematics):
    """Kinematics of a configuration, with velocities of zero.

    Joint Jacobians and placements are computed at once; mass matrix, bias forces and what follows
    from them when they are first used.

    Args:
        robot: the robot.
        q: (nq,) configuration.

    Raises:
        StateError: q has a wrong size, a NaN or a non-unit quaternion.
    """

    def __init__(self, robot: RobotModel, q: np.ndarray) -> None:
        self._rest = self._previous_velocity = np.zeros(robot.nv)
        self._mass_matrix_used = False
        self._mass_matrix: np.ndarray | None = None
        super().__init__(robot, State(np.array(q, dtype=float), self._rest))

    def __getstate__(self) -> Any:
        """Return the robot and the configuration."""
        return self.robot, self.state.q, self.previous_acceleration

    def set_configuration(self, q: np.ndarray, previous_velocity: np.ndarray | None = None) -> None:
        """Continue with another configuration (nq,), and velocity (nv,) before the step."""
        self._previous_velocity = self._rest if previous_velocity is None else previous_velocity
        self.update(State(np.array(q, dtype=float), self._rest))

    def _propagate(self, q: np.ndarray, v: np.ndarray) -> None:
        self._bias_forces: np.ndarray | None = None
        if self._mass_matrix_used:  # probably again, and its pass gives the Jacobians too
            self._mass_matrix = pin.crba(self.model, self.data, q, pin.Convention.WORLD)
        else:
            self._mass_matrix = None
            pin.computeJointJacobians(self.model, self.data, q)

    @property
    def previous_velocity(self) -> np.ndarray:
        """(nv,) velocity before the step, m/s and rad/s; zero unless set."""
        return self._previous_velocity

    @property
    def mass_matrix(self) -> np.ndarray:  # type: ignore[override]
        """(nv, nv) M(q), armature included."""
        found = self._mass_matrix
        if found is None:
            self._mass_matrix_used = True
            convention = pin.Convention.WORLD
            found = self._mass_matrix = pin.crba(self.model, self.data, self.state.q, convention)
        return found

    @property
    def bias_forces(self) -> np.ndarray:  # type: ignore[override]
        """(nv,) h(q, 0): gravity."""
        if self._bias_forces is None:
            self._bias_forces = pin.computeGeneralizedGravity(self.model, self.data, self.state.q)
        return self._bias_forces

    @property
    def p_com(self) -> np.ndarray:
        """Centre of mass (3,) in the world, m."""
        _ = self.mass_matrix  # whose pass leaves the CoM in Pinocchio's data
        return super().p_com

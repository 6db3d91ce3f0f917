"""Conversion between Pinocchio's coordinates and MuJoCo's, for a floating base.

| | Pinocchio | MuJoCo |
| --- | --- | --- |
| quaternion | x y z w | w x y z |
| base linear velocity | base axes | world axes |
| base angular velocity | base axes | base axes |
| base linear acceleration | base axes, spatial | world axes, classical |
| joints | model order | body tree order |
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.state import State


class CoordinateMap:
    """Converts states and accelerations of one robot.

    Args:
        order: (na,) for each actuated joint in Pinocchio's order, its index among
            MuJoCo's actuated joints.
    """

    def __init__(self, order: np.ndarray) -> None:
        self.order = np.asarray(order, dtype=int)
        # MuJoCo's index of each of Pinocchio's coordinates.
        self._q = np.concatenate(([0, 1, 2, 4, 5, 6, 3], 7 + self.order))
        self._v = np.concatenate((np.arange(6), 6 + self.order))

    def to_plant(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Return MuJoCo's (qpos, qvel) of a state."""
        qpos, qvel = np.empty_like(state.q), np.empty_like(state.v)
        qpos[self._q] = state.q
        qvel[self._v] = state.v
        qvel[:3] = _rotation(state.q) @ state.v[:3]
        return qpos, qvel

    def to_state(self, qpos: np.ndarray, qvel: np.ndarray) -> State:
        """Return the state of MuJoCo's (qpos, qvel), in new arrays."""
        q, v = qpos.take(self._q), qvel.take(self._v)
        v[:3] = v[:3].dot(_rotation(q))
        return State(q, v)

    def to_plant_acceleration(self, state: State, a: np.ndarray) -> np.ndarray:
        """Return MuJoCo's qacc of Pinocchio's acceleration.

        The derivative of `v_world = R v` is `R (a + ω × v)`: the spatial base
        acceleration lacks the term of the moving axes.
        """
        qacc = np.empty_like(a)
        qacc[self._v] = a
        qacc[:3] = _rotation(state.q) @ (a[:3] + np.cross(state.v[3:6], state.v[:3]))
        return qacc


def _rotation(q: np.ndarray) -> np.ndarray:
    """Return the rotation from base axes to world axes, (3, 3)."""
    rotation: np.ndarray = pin.XYZQUATToSE3(q[:7]).rotation
    return rotation

"""Between Pinocchio's coordinates and MuJoCo's, for a floating base.

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

from wbc.state import State


def rotation(xyzw: np.ndarray) -> np.ndarray:
    """(3, 3) rotation matrix of a unit quaternion x y z w."""
    x, y, z, w = xyzw.tolist()
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


class Convention:
    """Maps states, accelerations and torques of one robot.

    Args:
        order: (na,) for each actuated joint in Pinocchio's order, its place among
            MuJoCo's actuated joints.
    """

    def __init__(self, order: np.ndarray) -> None:
        self.order = np.asarray(order, dtype=int)
        self._q = 7 + self.order
        self._v = 6 + self.order

    def to_plant(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """MuJoCo's (qpos, qvel) of a state."""
        q, v = state.q, state.v
        qpos = np.empty_like(q)
        qvel = np.empty_like(v)
        qpos[:3] = q[:3]
        qpos[3] = q[6]
        qpos[4:7] = q[3:6]
        qpos[self._q] = q[7:]
        qvel[:3] = rotation(q[3:7]) @ v[:3]
        qvel[3:6] = v[3:6]
        qvel[self._v] = v[6:]
        return qpos, qvel

    def to_state(self, qpos: np.ndarray, qvel: np.ndarray) -> State:
        """The state of MuJoCo's (qpos, qvel); new arrays."""
        q = np.empty(qpos.size)
        v = np.empty(qvel.size)
        q[:3] = qpos[:3]
        q[3:6] = qpos[4:7]
        q[6] = qpos[3]
        q[7:] = qpos[self._q]
        v[:3] = qvel[:3] @ rotation(q[3:7])
        v[3:6] = qvel[3:6]
        v[6:] = qvel[self._v]
        return State(q, v)

    def to_plant_acceleration(self, state: State, a: np.ndarray) -> np.ndarray:
        """MuJoCo's qacc of Pinocchio's acceleration.

        The derivative of `v_world = R v` is `R (a + ω × v)`: the spatial base
        acceleration lacks the term of the moving axes.
        """
        qacc = np.empty_like(a)
        qacc[:3] = rotation(state.q[3:7]) @ (a[:3] + np.cross(state.v[3:6], state.v[:3]))
        qacc[3:6] = a[3:6]
        qacc[self._v] = a[6:]
        return qacc

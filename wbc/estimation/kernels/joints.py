"""The joint filter's step; see `wbc.estimation.joints`."""

from __future__ import annotations

import numpy as np

from wbc.jit.compile import subkernel


@subkernel
def update_joints(
    U: np.ndarray,
    joints: np.ndarray,
    acceleration: np.ndarray,
    read_position: np.ndarray,
    read_velocity: np.ndarray,
) -> None:
    """`[q, v] ← U [q, v, a, reading of q, reading of v]`, joint by joint, in place.

    Args:
        U: (2, 5).
        joints: (2, na) positions and velocities, rad and rad/s.
        acceleration: (na,) rad/s².
        read_position: (na,) rad.
        read_velocity: (na,) rad/s.
    """
    position, velocity = joints[0], joints[1]
    for i in range(position.size):
        q, v, a = position[i], velocity[i], acceleration[i]
        x, y = read_position[i], read_velocity[i]
        position[i] = U[0, 0] * q + U[0, 1] * v + U[0, 2] * a + U[0, 3] * x + U[0, 4] * y
        velocity[i] = U[1, 0] * q + U[1, 1] * v + U[1, 2] * a + U[1, 3] * x + U[1, 4] * y

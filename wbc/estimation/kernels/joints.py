"""The joint filter's step; see `wbc.estimation.joints`."""

from __future__ import annotations

import numpy as np

from wbc.jit.compile import subkernel


@subkernel
def update_joints(
    U: np.ndarray,
    gate: float,
    dt: float,
    joints: np.ndarray,
    acceleration: np.ndarray,
    read_position: np.ndarray,
    read_velocity: np.ndarray,
) -> None:
    """`[q, v] ← U [q, v, a, reading of q, reading of v]`, joint by joint, in place.

    Args:
        U: (2, 2, 5): for a joint that does what is foreseen, then for one that does not.
        gate: difference of the read from the foreseen velocity that tells them apart, rad/s.
        dt: period, s.
        joints: (3, na) positions and velocities, rad and rad/s, and the differences of the last
            period, rad/s: only the second one in a row is more than noise.
        acceleration: (na,) rad/s².
        read_position: (na,) rad.
        read_velocity: (na,) rad/s.
    """
    position, velocity, last = joints[0], joints[1], joints[2]
    for i in range(position.size):
        q, v, a = position[i], velocity[i], acceleration[i]
        x, y = read_position[i], read_velocity[i]
        off = y - v - dt * a
        M = U[1] if min(off, last[i]) > gate or max(off, last[i]) < -gate else U[0]
        last[i] = off
        position[i] = M[0, 0] * q + M[0, 1] * v + M[0, 2] * a + M[0, 3] * x + M[0, 4] * y
        velocity[i] = M[1, 0] * q + M[1, 1] * v + M[1, 2] * a + M[1, 3] * x + M[1, 4] * y

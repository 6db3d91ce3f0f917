"""Placements of the soles and velocity of the centre of mass, as the gait reads them."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import argument_types, kernel, subkernel_or

#: Where a sole is on the joint that carries it.
SOLE = np.dtype(
    [
        ("joint", np.int64),
        ("axis", float, (3,)),  # x axis of the sole, joint axes
        ("position", float, (3,)),  # centre of the sole, joint axes, m
    ],
    align=True,
)


def _base_momentum(M: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    np.dot(M[:3], v, out=out)


@subkernel_or(_base_momentum)
def base_momentum(M: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    """Write the robot's linear momentum in base axes (3,), kg·m/s: the first rows of M v."""
    for i in range(3):
        total = 0.0
        for j in range(v.size):
            total += M[i, j] * v[j]
        out[i] = total


@kernel(
    argument_types(
        np.zeros((1, 12)), np.zeros((1, 1)), np.zeros(1), np.zeros(1, SOLE), 1.0, np.zeros(1)
    )
)
def read_ground(
    joint_placements: np.ndarray,
    M: np.ndarray,
    v: np.ndarray,
    soles: np.ndarray,
    mass: float,
    out: np.ndarray,
) -> None:
    """Write the placements of both soles and the horizontal velocity of the centre of mass.

    See `wbc.kinematics.Kinematics.v_com`.

    Args:
        joint_placements: (njoints, 12), see `wbc.kinematics.Kinematics`.
        M: (nv, nv) mass matrix.
        v: (nv,) generalised velocity.
        soles: (2,) of the type `SOLE`.
        mass: of the robot, kg.
        out: (13,) per sole x, y, z of its centre (m) and yaw (rad), then the velocity of the
            centre of mass along x and y (m/s), all in world axes; workspace.
    """
    for k in range(2):
        sole = soles[k]
        axis, position = sole["axis"], sole["position"]
        T = joint_placements[sole["joint"]]
        for i in range(3):
            out[4 * k + i] = (
                T[i] * position[0] + T[3 + i] * position[1] + T[6 + i] * position[2] + T[9 + i]
            )
        x = T[0] * axis[0] + T[3] * axis[1] + T[6] * axis[2]
        y = T[1] * axis[0] + T[4] * axis[1] + T[7] * axis[2]
        out[4 * k + 3] = math.atan2(y, x)
    base, momentum = joint_placements[1], out[10:13]
    base_momentum(M, v, momentum)
    for i in range(2):
        total = base[i] * momentum[0] + base[3 + i] * momentum[1] + base[6 + i] * momentum[2]
        out[8 + i] = total / mass

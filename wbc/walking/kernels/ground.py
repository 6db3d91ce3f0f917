"""Placements of the soles and motion of the centre of mass, as the gait reads them."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import argument_types, kernel, subkernel_or

#: Mass of the robot, and where each sole is on the joint that carries it.
BODY = np.dtype(
    [
        ("mass", float),  # kg
        ("joint", np.int64, (2,)),
        ("axis", float, (2, 3)),  # x axis of the sole, joint axes
        ("normal", float, (2, 3)),  # z axis of the sole, joint axes
        ("position", float, (2, 3)),  # centre of the sole, joint axes, m
    ],
    align=True,
)


def _base_momentum(M: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    np.dot(M[:6], v, out=out)


@subkernel_or(_base_momentum)
def base_momentum(M: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    """Write the momentum (6,) about the base's origin in base axes: the first rows of M v.

    Linear, kg·m/s, then angular, kg·m²/s.
    """
    for i in range(6):
        total = 0.0
        for j in range(v.size):
            total += M[i, j] * v[j]
        out[i] = total


@kernel(
    argument_types(np.zeros((1, 12)), np.zeros((1, 1)), np.zeros(1), np.zeros(1, BODY), np.zeros(1))
)
def read_ground(
    joint_placements: np.ndarray, M: np.ndarray, v: np.ndarray, body: np.ndarray, out: np.ndarray
) -> None:
    """Write the placements of both soles, and motion and momentum of the centre of mass.

    The centre of mass c in base axes and the momentum are read off the base rows of M:
    `M[0:3, 3:6] = −m [c]×`, and `M[0:6] v` is the momentum about the base's origin in base
    axes, of which `c × M[0:3] v` is that of the centre of mass; see
    `wbc.kinematics.Kinematics.centroid`.

    Args:
        joint_placements: (njoints, 12), see `wbc.kinematics.Kinematics`.
        M: (nv, nv) mass matrix.
        v: (nv,) generalised velocity.
        body: (1,) of the type `BODY`.
        out: (27,) per sole x, y, z of its centre (m) and yaw (rad), then position (m) and
            velocity (m/s) of the centre of mass, and the angular momentum about it (kg·m²/s), all
            in world axes; workspace (6,); per sole its rise per metre along x and along y.
    """
    b = body[0]
    mass, axes, normals, positions = b["mass"], b["axis"], b["normal"], b["position"]
    for k in range(2):
        axis, normal, position = axes[k], normals[k], positions[k]
        T = joint_placements[b["joint"][k]]
        for i in range(3):
            out[4 * k + i] = (
                T[i] * position[0] + T[3 + i] * position[1] + T[6 + i] * position[2] + T[9 + i]
            )
        x = T[0] * axis[0] + T[3] * axis[1] + T[6] * axis[2]
        y = T[1] * axis[0] + T[4] * axis[1] + T[7] * axis[2]
        out[4 * k + 3] = math.atan2(y, x)
        z = T[2] * normal[0] + T[5] * normal[1] + T[8] * normal[2]
        for i in range(2):
            along = T[i] * normal[0] + T[3 + i] * normal[1] + T[6 + i] * normal[2]
            # A sole on edge has no slope.
            out[23 + 2 * k + i] = -along / z if z > 0.5 else 0.0
    base, momentum = joint_placements[1], out[17:23]
    base_momentum(M, v, momentum)
    c0, c1, c2 = M[1, 5] / mass, M[2, 3] / mass, M[0, 4] / mass
    p0, p1, p2 = momentum[0], momentum[1], momentum[2]
    h0 = momentum[3] - (c1 * p2 - c2 * p1)
    h1 = momentum[4] - (c2 * p0 - c0 * p2)
    h2 = momentum[5] - (c0 * p1 - c1 * p0)
    for i in range(3):
        out[8 + i] = base[i] * c0 + base[3 + i] * c1 + base[6 + i] * c2 + base[9 + i]
        out[11 + i] = (base[i] * p0 + base[3 + i] * p1 + base[6 + i] * p2) / mass
        out[14 + i] = base[i] * h0 + base[3 + i] * h1 + base[6 + i] * h2

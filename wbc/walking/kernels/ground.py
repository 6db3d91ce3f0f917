"""Soles, centre of mass, tilt and height of the body, as gait and balance read them."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import argument_types, kernel, subkernel, subkernel_or

#: What `read_ground` has to know of the robot, and its workspace.
BODY = np.dtype(
    [
        ("mass", float),  # kg
        ("weight", float),  # N
        ("gravity", float),  # m/s²
        ("joint", np.int64, (2,)),
        ("axis", float, (2, 3)),  # x axis of the sole, joint axes
        ("normal", float, (2, 3)),  # z axis of the sole, joint axes
        ("position", float, (2, 3)),  # centre of the sole, joint axes, m
        ("up", float, (3,)),  # world's z axis in the nominal posture, base axes
        ("momentum", float, (6,)),  # workspace
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


@subkernel
def _read_sole(
    T: np.ndarray, axis: np.ndarray, position: np.ndarray
) -> tuple[complex, float, float]:
    """Ground point (m), heading (rad) and height (m) of a sole.

    Args:
        T: (12,) placement of the joint, see `wbc.kinematics.Kinematics`.
        axis: (3,) x axis of the sole, joint axes.
        position: (3,) centre of the sole, joint axes, m.
    """
    x = T[0] * position[0] + T[3] * position[1] + T[6] * position[2] + T[9]
    y = T[1] * position[0] + T[4] * position[1] + T[7] * position[2] + T[10]
    z = T[2] * position[0] + T[5] * position[1] + T[8] * position[2] + T[11]
    ahead = T[0] * axis[0] + T[3] * axis[1] + T[6] * axis[2]
    aside = T[1] * axis[0] + T[4] * axis[1] + T[7] * axis[2]
    return complex(x, y), math.atan2(aside, ahead), z


@subkernel
def _read_slope(T: np.ndarray, normal: np.ndarray) -> complex:
    """Slope of a sole, from its z axis (3,) in joint axes; see `_read_sole`."""
    x = T[0] * normal[0] + T[3] * normal[1] + T[6] * normal[2]
    y = T[1] * normal[0] + T[4] * normal[1] + T[7] * normal[2]
    z = T[2] * normal[0] + T[5] * normal[1] + T[8] * normal[2]
    # A sole on edge has no slope.
    return complex(-x / z, -y / z) if z > 0.5 else 0j


@subkernel
def _read_speed(V: np.ndarray, position: np.ndarray) -> float:
    """Speed of the centre of a sole, m/s, from the velocity (6,) of its joint; see `_read_sole`."""
    x = V[0] + V[4] * position[2] - V[5] * position[1]
    y = V[1] + V[5] * position[0] - V[3] * position[2]
    z = V[2] + V[3] * position[1] - V[4] * position[0]
    return math.sqrt(x * x + y * y + z * z)


@kernel(
    argument_types(
        np.zeros((1, 12)), np.zeros((1, 6)), np.zeros((1, 1)), np.zeros(1), np.zeros(1, BODY)
    )
)
def read_ground(
    joint_placements: np.ndarray,
    joint_velocities: np.ndarray,
    M: np.ndarray,
    v: np.ndarray,
    body: np.ndarray,
) -> tuple[
    tuple[complex, float, float],
    tuple[complex, float, float],
    tuple[complex, complex, float, float, complex, complex],
    tuple[complex, complex],
    tuple[float, float],
    tuple[float, float],
    tuple[float, float],
]:
    """Return placements of both soles, motion of the centre of mass, tilt and height of the body.

    The centre of mass c in base axes and the momentum are read off the base rows of M:
    `M[0:3, 3:6] = −m [c]×`, and `M[0:6] v` is the momentum about the base's origin in base
    axes, of which `c × M[0:3] v` is that of the centre of mass; see
    `wbc.kinematics.Kinematics.centroid`.

    Args:
        joint_placements: (njoints, 12), see `wbc.kinematics.Kinematics`.
        joint_velocities: (njoints, 6), see there.
        M: (nv, nv) mass matrix.
        v: (nv,) generalised velocity.
        body: (1,) of the type `BODY`.

    Returns:
        Per sole its ground point (m), heading (rad) and height (m); of the centre of mass its
        ground point (m), horizontal velocity (m/s), height (m), vertical velocity (m/s) and angular
        momentum about the ground below it and about itself, see
        `wbc.walking.ground_kinematics.CentroidalMotion` (m·s); of both soles the slope, the rise
        per metre along x, and along y as the imaginary part, and the speed of the centre, m/s;
        angle of the body from the vertical (rad) and its rate (rad/s); height of the base (m) and
        its vertical velocity (m/s). World axes.
    """
    b = body[0]
    mass, axes, normals, positions = b["mass"], b["axis"], b["normal"], b["position"]
    left_joint, right_joint = joint_placements[b["joint"][0]], joint_placements[b["joint"][1]]
    left = _read_sole(left_joint, axes[0], positions[0])
    right = _read_sole(right_joint, axes[1], positions[1])
    slopes = (_read_slope(left_joint, normals[0]), _read_slope(right_joint, normals[1]))
    speeds = (
        _read_speed(joint_velocities[b["joint"][0]], positions[0]),
        _read_speed(joint_velocities[b["joint"][1]], positions[1]),
    )
    base, p = joint_placements[1], b["momentum"]
    base_momentum(M, v, p)
    c0, c1, c2 = M[1, 5] / mass, M[2, 3] / mass, M[0, 4] / mass
    h0 = p[3] - (c1 * p[2] - c2 * p[1])
    h1 = p[4] - (c2 * p[0] - c0 * p[2])
    h2 = p[5] - (c0 * p[1] - c1 * p[0])
    x = base[0] * c0 + base[3] * c1 + base[6] * c2 + base[9]
    y = base[1] * c0 + base[4] * c1 + base[7] * c2 + base[10]
    z = base[2] * c0 + base[5] * c1 + base[8] * c2 + base[11]
    velocity = complex(
        (base[0] * p[0] + base[3] * p[1] + base[6] * p[2]) / mass,
        (base[1] * p[0] + base[4] * p[1] + base[7] * p[2]) / mass,
    )
    rising = (base[2] * p[0] + base[5] * p[1] + base[8] * p[2]) / mass
    l_x = base[0] * h0 + base[3] * h1 + base[6] * h2
    l_y = base[1] * h0 + base[4] * h1 + base[7] * h2
    height = z - 0.5 * (left[2] + right[2])
    centroidal = complex(l_y, -l_x) / b["weight"]
    momentum = velocity * (height / b["gravity"]) + centroidal
    # The world's vertical u in base axes turns as u̇ = u × ω; the body's own is constant there.
    u0, u1, u2, up = base[2], base[5], base[8], b["up"]
    cosine = min(max(up[0] * u0 + up[1] * u1 + up[2] * u2, -1.0), 1.0)
    derivative = (
        up[0] * (u1 * v[5] - u2 * v[4])
        + up[1] * (u2 * v[3] - u0 * v[5])
        + up[2] * (u0 * v[4] - u1 * v[3])
    )
    # Upright, the tilt has no direction yet: its rate is zero there and grows with it.
    rate = -derivative / max(math.sqrt(1.0 - cosine * cosine), 1e-3)
    com = (complex(x, y), velocity, z, rising, momentum, centroidal)
    base_motion = (base[11], u0 * v[0] + u1 * v[1] + u2 * v[2])
    return left, right, com, slopes, speeds, (math.acos(cosine), rate), base_motion

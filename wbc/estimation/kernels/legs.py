"""Forward kinematics of the chains from the base to IMU and soles, and the state of the base."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from wbc.estimation.kernels.filter_record import FEET, filter_type
from wbc.estimation.kernels.matrix import combine
from wbc.estimation.kernels.rotation import (
    copy,
    cross,
    multiply,
    quaternion,
    rotate,
    rotate_back,
)
from wbc.jit.compile import argument_types, kernel, subkernel

#: A link of a chain. A joint with motion subspace S = (slide, axis) at a fixed placement
#: (R, p) turns and moves what follows by `R (1 + sin q [axis ×] + (1 − cos q) [axis ×]²)` and
#: `p + q R slide`; a link without a joint (index −1) has the placement alone.
LINK = np.dtype(
    [
        ("rotation", float, (3, 3)),  # R
        ("sine", float, (3, 3)),  # R [axis ×]
        ("versine", float, (3, 3)),  # R [axis ×]²
        ("position", float, (3,)),  # p, m
        ("slide", float, (3,)),  # m/rad or m/m, axes after the joint
        ("axis", float, (3,)),  # axes after the joint
        ("joint", np.int64),  # index into (na,) or −1
    ],
    align=True,
)


@lru_cache
def poses_type(feet: int) -> np.dtype:
    """Return the type of where base and soles are, as seen from the IMU."""
    return np.dtype(
        [
            ("sole_position", float, (feet, 3)),  # IMU axes, m
            ("sole_rotation", float, (feet, 3, 3)),  # sole axes to IMU axes
            ("base_position", float, (3,)),  # IMU axes, m
            ("base_rotation", float, (3, 3)),  # base axes to IMU axes
            ("linear", float, (3,)),  # velocity of the IMU relative to the base, IMU axes, m/s
            ("angular", float, (3,)),  # rad/s
            # Workspace.
            ("matrices", float, (4, 3, 3)),
            ("vector", float, (3,)),
        ],
        align=True,
    )


_JOINTS = np.zeros((2, 1))
_VECTOR = np.zeros(3)


@subkernel
def _move_along(
    link: np.ndarray, q: np.ndarray, R: np.ndarray, p: np.ndarray, work: np.ndarray
) -> None:
    """Move a frame (R, p) over one link; `work` is a (4, 3, 3) workspace."""
    local, turned, moved = work[0], work[1], work[2, 0]
    rotate(R, link["position"], moved)
    for i in range(3):
        p[i] += moved[i]
    joint = link["joint"]
    angle = q[joint] if joint >= 0 else 0.0
    s, c = math.sin(angle), 1.0 - math.cos(angle)
    combine(link["rotation"], link["sine"], link["versine"], s, c, local)
    multiply(R, local, turned)
    copy(turned, R)
    if joint >= 0:
        # A joint slides along its own axis, which it does not turn.
        rotate(R, link["slide"], moved)
        for i in range(3):
            p[i] += angle * moved[i]


@subkernel
def find_poses(links: np.ndarray, ends: np.ndarray, joints: np.ndarray, out: np.ndarray) -> None:
    """Compute the poses from joint positions and velocities.

    Args:
        links: chain of the IMU, then those of the soles.
        ends: (1 + feet,) index after the last link of each chain.
        joints: (2, na) positions, rad or m, and velocities, rad/s or m/s.
        out: the poses.
    """
    q, v = joints[0], joints[1]
    work = out["matrices"]
    R, moved = work[3], work[2, 0]
    base_R, base_p = out["base_rotation"], out["base_position"]
    linear, angular = out["linear"], out["angular"]
    p = out["vector"]
    # The IMU in base axes. Its velocity: every joint adds ω = a q̇ about its own origin; what
    # follows moves with the sum of the joints before it.
    for i in range(3):
        p[i] = linear[i] = angular[i] = 0.0
        for j in range(3):
            R[i, j] = 1.0 if i == j else 0.0
    for n in range(ends[0]):
        link = links[n]
        x, y, z = p[0], p[1], p[2]
        _move_along(link, q, R, p, work)
        x, y, z = p[0] - x, p[1] - y, p[2] - z
        linear[0] += angular[1] * z - angular[2] * y
        linear[1] += angular[2] * x - angular[0] * z
        linear[2] += angular[0] * y - angular[1] * x
        joint = link["joint"]
        if joint >= 0:
            rate = v[joint]
            rotate(R, link["axis"], moved)
            for i in range(3):
                angular[i] += rate * moved[i]
            rotate(R, link["slide"], moved)
            for i in range(3):
                linear[i] += rate * moved[i]
    # Turn it round: base in IMU axes.
    for i in range(3):
        for j in range(3):
            base_R[i, j] = R[j, i]
    x, y, z = linear[0], linear[1], linear[2]
    for i in range(3):
        linear[i] = base_R[i, 0] * x + base_R[i, 1] * y + base_R[i, 2] * z
    x, y, z = angular[0], angular[1], angular[2]
    for i in range(3):
        angular[i] = base_R[i, 0] * x + base_R[i, 1] * y + base_R[i, 2] * z
    for i in range(3):
        base_p[i] = -(base_R[i, 0] * p[0] + base_R[i, 1] * p[1] + base_R[i, 2] * p[2])
    for foot in range(out["sole_position"].shape[0]):
        R, p = out["sole_rotation"][foot], out["sole_position"][foot]
        for i in range(3):
            p[i] = base_p[i]
            for j in range(3):
                R[i, j] = base_R[i, j]
        for n in range(ends[foot], ends[foot + 1]):
            _move_along(links[n], q, R, p, work)


@subkernel
def find_state(
    f: np.ndarray, seen: np.ndarray, joints: np.ndarray, q: np.ndarray, v: np.ndarray
) -> None:
    """Write configuration and velocity of the robot; see `write_state`."""
    R, vectors, gyro, bias = f["R"], f["vectors"], f["gyro"], f["gyro_bias"]
    origin, work = f["origin"], seen["matrices"]
    base_R, base_p = seen["base_rotation"], seen["base_position"]
    rotate(R, base_p, q[:3])
    for i in range(3):
        q[i] += origin[i] + vectors[1, i]
    base, spare = work[0], work[1]
    multiply(R, base_R, base)
    quaternion(base, q[3:7])
    linear, angular, arm = spare[0], spare[1], spare[2]
    rotate_back(R, vectors[0], linear)
    for i in range(3):
        linear[i] -= seen["linear"][i]
        angular[i] = gyro[i] - bias[i] - seen["angular"][i]
    cross(base_p, angular, arm)
    for i in range(3):
        linear[i] -= arm[i]
    rotate_back(base_R, linear, v[:3])
    rotate_back(base_R, angular, v[3:6])
    for i in range(joints.shape[1]):
        q[7 + i] = joints[0, i]
        v[6 + i] = joints[1, i]


@kernel(
    *(
        argument_types(
            np.zeros(1, filter_type(n)), np.zeros(1, poses_type(n)), _JOINTS, _VECTOR, _VECTOR
        )
        for n in FEET
    )
)
def write_state(
    filter_: np.ndarray,
    poses: np.ndarray,
    joints: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
) -> None:
    """Write configuration and velocity of the robot.

    Args:
        filter_: (1,) state of the IMU.
        poses: (1,) as seen from the IMU.
        joints: (2, na) positions and velocities, rad and rad/s.
        q: (nq,) result.
        v: (nv,) result.
    """
    find_state(filter_[0], poses[0], joints, q, v)

"""Frames and centroid: Jacobians, velocities and bias accelerations, from Pinocchio's passes."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import subkernel
from wbc.qp.kernels.groups import Frames, Tree


@subkernel
def sweep(tree: Tree, J: np.ndarray, v: np.ndarray) -> None:
    """Compute spatial velocity and bias acceleration of all bodies, at the world's origin.

    With joint columns J_i of the world Jacobian, v_i = v_p + J_i q̇_i and
    a_i = a_p + v_p × J_i q̇_i (Featherstone 2008, §2.10: each column moves with its body).

    Args:
        tree: the joints.
        J: (nv, 6) transposed world Jacobian, linear part first.
        v: (nv,).
    """
    velocity, bias = tree.velocity, tree.bias
    for k in range(6):
        s = 0.0
        for c in range(6):
            s += J[c, k] * v[c]
        velocity[0, k] = s
        bias[0, k] = 0.0
    for i in range(1, tree.parent.size):
        p, c = tree.parent[i], i + 5
        rate = v[c]
        x0, x1, x2 = J[c, 0] * rate, J[c, 1] * rate, J[c, 2] * rate
        r0, r1, r2 = J[c, 3] * rate, J[c, 4] * rate, J[c, 5] * rate
        u0, u1, u2 = velocity[p, 0], velocity[p, 1], velocity[p, 2]
        w0, w1, w2 = velocity[p, 3], velocity[p, 4], velocity[p, 5]
        bias[i, 0] = bias[p, 0] + w1 * x2 - w2 * x1 + u1 * r2 - u2 * r1
        bias[i, 1] = bias[p, 1] + w2 * x0 - w0 * x2 + u2 * r0 - u0 * r2
        bias[i, 2] = bias[p, 2] + w0 * x1 - w1 * x0 + u0 * r1 - u1 * r0
        bias[i, 3] = bias[p, 3] + w1 * r2 - w2 * r1
        bias[i, 4] = bias[p, 4] + w2 * r0 - w0 * r2
        bias[i, 5] = bias[p, 5] + w0 * r1 - w1 * r0
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = u0 + x0, u1 + x1, u2 + x2
        velocity[i, 3], velocity[i, 4], velocity[i, 5] = w0 + r0, w1 + r1, w2 + r2


@subkernel
def place_frames(frames: Frames, joint_placements: np.ndarray) -> None:
    """Compute the placement of each frame in the world.

    Args:
        frames: the frames.
        joint_placements: (1 + bodies, 12) of the universe and all joints, see
            `wbc.kinematics.Kinematics.joint_placements`.
    """
    for k in range(frames.body.size):
        joint = joint_placements[frames.body[k] + 1]
        local, out = frames.in_body[k], frames.placement[k]
        for i in range(3):
            r0, r1, r2 = joint[i], joint[3 + i], joint[6 + i]
            for j in range(4):
                out[i, j] = r0 * local[0, j] + r1 * local[1, j] + r2 * local[2, j]
            out[i, 3] += joint[9 + i]


@subkernel
def move_frames(tree: Tree, frames: Frames, J: np.ndarray) -> None:
    """Compute Jacobian, velocity and classical bias acceleration of each frame's origin."""
    for k in range(1, frames.body.size):
        x, y, z = frames.placement[k, 0, 3], frames.placement[k, 1, 3], frames.placement[k, 2, 3]
        body = frames.body[k]
        out = frames.jacobian[k]
        i = body
        while True:
            first, last = (0, 6) if i == 0 else (i + 5, i + 6)
            for c in range(first, last):
                r0, r1, r2 = J[c, 3], J[c, 4], J[c, 5]
                out[0, c] = J[c, 0] + r1 * z - r2 * y
                out[1, c] = J[c, 1] + r2 * x - r0 * z
                out[2, c] = J[c, 2] + r0 * y - r1 * x
                out[3, c], out[4, c], out[5, c] = r0, r1, r2
            if i == 0:
                break
            i = tree.parent[i]
        spatial, bias, velocity = tree.velocity[body], tree.bias[body], frames.velocity[k]
        w0, w1, w2 = spatial[3], spatial[4], spatial[5]
        v0 = spatial[0] + w1 * z - w2 * y
        v1 = spatial[1] + w2 * x - w0 * z
        v2 = spatial[2] + w0 * y - w1 * x
        velocity[0], velocity[1], velocity[2] = v0, v1, v2
        velocity[3], velocity[4], velocity[5] = w0, w1, w2
        a, out_bias = bias, frames.bias[k]
        out_bias[0] = a[0] + a[4] * z - a[5] * y + w1 * v2 - w2 * v1
        out_bias[1] = a[1] + a[5] * x - a[3] * z + w2 * v0 - w0 * v2
        out_bias[2] = a[2] + a[3] * y - a[4] * x + w0 * v1 - w1 * v0
        out_bias[3], out_bias[4], out_bias[5] = a[3], a[4], a[5]


@subkernel
def move_centroid(
    frames: Frames, M: np.ndarray, h: np.ndarray, v: np.ndarray, mass: float, gravity: np.ndarray
) -> None:
    """Compute entry 0 of the frames, see `wbc.kinematics.Kinematics.centroid`.

    The CoM in base axes is read off the base rows of M: M[0:3, 3:6] = −m [c]×.
    """
    place, J = frames.placement[0], frames.jacobian[0]
    velocity, bias = frames.velocity[0], frames.bias[0]
    b0, b1, b2 = M[1, 5] / mass, M[2, 3] / mass, M[0, 4] / mass
    lever = (
        place[0, 0] * b0 + place[0, 1] * b1 + place[0, 2] * b2,
        place[1, 0] * b0 + place[1, 1] * b1 + place[1, 2] * b2,
        place[2, 0] * b0 + place[2, 1] * b1 + place[2, 2] * b2,
    )
    for i in range(3):
        r0, r1, r2 = place[i, 0], place[i, 1], place[i, 2]
        for c in range(v.size):
            J[i, c] = r0 * M[0, c] + r1 * M[1, c] + r2 * M[2, c]
            J[3 + i, c] = r0 * M[3, c] + r1 * M[4, c] + r2 * M[5, c]
        bias[i] = r0 * h[0] + r1 * h[1] + r2 * h[2]
        bias[3 + i] = r0 * h[3] + r1 * h[4] + r2 * h[5]
    c0, c1, c2 = lever
    for c in range(v.size):
        p0, p1, p2 = J[0, c], J[1, c], J[2, c]
        J[3, c] -= c1 * p2 - c2 * p1
        J[4, c] -= c2 * p0 - c0 * p2
        J[5, c] -= c0 * p1 - c1 * p0
    p0, p1, p2 = bias[0], bias[1], bias[2]
    bias[3] -= c1 * p2 - c2 * p1
    bias[4] -= c2 * p0 - c0 * p2
    bias[5] -= c0 * p1 - c1 * p0
    for i in range(3):
        for c in range(v.size):
            J[i, c] /= mass
        bias[i] = bias[i] / mass + gravity[i]
    for i in range(6):
        s = 0.0
        for c in range(v.size):
            s += J[i, c] * v[c]
        velocity[i] = s
    for i in range(3):
        place[i, 3] += lever[i]


@subkernel
def log3(R: np.ndarray, S: np.ndarray, out: np.ndarray) -> None:
    """out ← log(R Sᵀ), for rotations R and S."""
    Q = (
        R[0, 0] * S[0, 0] + R[0, 1] * S[0, 1] + R[0, 2] * S[0, 2],
        R[1, 0] * S[1, 0] + R[1, 1] * S[1, 1] + R[1, 2] * S[1, 2],
        R[2, 0] * S[2, 0] + R[2, 1] * S[2, 1] + R[2, 2] * S[2, 2],
    )
    x = R[2, 0] * S[1, 0] + R[2, 1] * S[1, 1] + R[2, 2] * S[1, 2]
    x -= R[1, 0] * S[2, 0] + R[1, 1] * S[2, 1] + R[1, 2] * S[2, 2]
    y = R[0, 0] * S[2, 0] + R[0, 1] * S[2, 1] + R[0, 2] * S[2, 2]
    y -= R[2, 0] * S[0, 0] + R[2, 1] * S[0, 1] + R[2, 2] * S[0, 2]
    z = R[1, 0] * S[0, 0] + R[1, 1] * S[0, 1] + R[1, 2] * S[0, 2]
    z -= R[0, 0] * S[1, 0] + R[0, 1] * S[1, 1] + R[0, 2] * S[1, 2]
    sine = 0.5 * math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (Q[0] + Q[1] + Q[2] - 1.0)
    angle = math.atan2(sine, cosine)
    if cosine > -0.99:
        factor = 0.5 * angle / sine if sine > 1e-8 else 0.5
        out[0], out[1], out[2] = factor * x, factor * y, factor * z
        return
    # Near half a turn the axis follows from the symmetric part, its sign from the sines.
    scale = angle / math.sqrt(1.0 - cosine)
    out[0] = scale * math.copysign(math.sqrt(max(Q[0] - cosine, 0.0)), x)
    out[1] = scale * math.copysign(math.sqrt(max(Q[1] - cosine, 0.0)), y)
    out[2] = scale * math.copysign(math.sqrt(max(Q[2] - cosine, 0.0)), z)

"""Pairs of bodies that are near each other, and rates of the distances between their points."""

from __future__ import annotations

import numpy as np

from wbc.jit.compile import kernel, subkernel

_TRIALS = 8  # planes tried between two shapes


@subkernel
def farthest_along(
    T: np.ndarray, vertices: np.ndarray, start: int, stop: int, n: np.ndarray, out: np.ndarray
) -> None:
    """Write to `out` the vertex, in world axes, that is farthest along n.

    Args:
        T: (12,) placement of the joint, columns of the rotation first.
        vertices: (V, 3) vertices in the axes of their joints, m.
        start, stop: those of the shape.
        n: (3,) direction, world.
        out: (3,) to be written, m.
    """
    a = T[0] * n[0] + T[1] * n[1] + T[2] * n[2]
    b = T[3] * n[0] + T[4] * n[1] + T[5] * n[2]
    c = T[6] * n[0] + T[7] * n[1] + T[8] * n[2]
    best, most = start, -np.inf
    for j in range(start, stop):
        along = a * vertices[j, 0] + b * vertices[j, 1] + c * vertices[j, 2]
        if along > most:
            best, most = j, along
    x, y, z = vertices[best, 0], vertices[best, 1], vertices[best, 2]
    for i in range(3):
        out[i] = T[i] * x + T[3 + i] * y + T[6 + i] * z + T[9 + i]


@kernel(
    "int64(float64[:,:], int64[::1], float64[:,::1], float64[::1], float64[::1], int64[:,::1], "
    "float64[:,::1], int64[::1], float64, int64[::1])"
)
def separable_pairs_left_out(
    placements: np.ndarray,
    bodies: np.ndarray,
    centers: np.ndarray,
    radii: np.ndarray,
    errors: np.ndarray,
    pairs: np.ndarray,
    vertices: np.ndarray,
    starts: np.ndarray,
    distance: float,
    found: np.ndarray,
) -> int:
    """Write the pairs of shapes that may be nearer than a distance, and return their number.

    Left out are those whose enclosing spheres are farther apart, and those between which a plane
    is found with more room than that on both sides together. Each plane's normal is the present
    estimate of the shortest vector between the two, which the vertices farthest towards each other
    improve (Gilbert, An iterative procedure for computing the minimum of a quadratic form on a
    convex set, SIAM Journal on Control 1966).

    Args:
        placements: (njoints, 12), see `wbc.kinematics.Kinematics.joint_placements`.
        bodies: (s,) joint of each shape.
        centers: (s, 3) centres of their enclosing spheres in the axes of the joints, m.
        radii: (s,) m.
        errors: (s,) by how much a shape may extend beyond the hull of its vertices, m.
        pairs: (p, 2) shapes of each pair.
        vertices: (V, 3) vertices of all shapes in the axes of their joints, m.
        starts: (s + 1,) first vertex of each shape.
        distance: m.
        found: (p,) to be written.
    """
    world = np.empty((bodies.size, 3))
    for s in range(bodies.size):
        T = placements[bodies[s]]
        x, y, z = centers[s, 0], centers[s, 1], centers[s, 2]
        for i in range(3):
            world[s, i] = T[i] * x + T[3 + i] * y + T[6 + i] * z + T[9 + i]
    v, n, one, other = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    count = 0
    for k in range(pairs.shape[0]):
        first, second = pairs[k, 0], pairs[k, 1]
        reach = radii[first] + radii[second] + distance
        square = 0.0
        for i in range(3):
            v[i] = world[second, i] - world[first, i]
            square += v[i] * v[i]
        if square >= reach * reach:
            continue
        clear = distance + errors[first] + errors[second]
        near = True
        for _ in range(_TRIALS):
            length = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
            if length < 1e-9:
                break
            for i in range(3):
                n[i] = v[i] / length
            placement = placements[bodies[first]]
            farthest_along(placement, vertices, starts[first], starts[first + 1], n, one)
            for i in range(3):
                n[i] = -n[i]
            placement = placements[bodies[second]]
            farthest_along(placement, vertices, starts[second], starts[second + 1], n, other)
            room, towards, step = 0.0, 0.0, 0.0
            for i in range(3):
                gap = other[i] - one[i]
                room -= n[i] * gap
                towards += v[i] * (v[i] - gap)
                step += (v[i] - gap) * (v[i] - gap)
            if room >= clear:
                near = False
                break
            if step < 1e-12 or length <= clear:
                break
            share = min(max(towards / step, 0.0), 1.0)
            for i in range(3):
                v[i] += share * (other[i] - one[i] - v[i])
        if near:
            found[count] = k
            count += 1
    return count


@kernel(
    "void(float64[:,::1], int64[::1], int64[:,::1], float64[:,:,::1], float64[:,::1], "
    "float64[::1], float64[:,::1], float64[::1])"
)
def distance_rates(
    J: np.ndarray,
    parents: np.ndarray,
    joints: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    v: np.ndarray,
    rows: np.ndarray,
    bias: np.ndarray,
) -> None:
    """Write `ḋ = nᵀ (J₂ − J₁) v` of pairs of points, and the part `nᵀ (J̇₂ − J̇₁) v` of d̈.

    A body's velocity and bias acceleration at the world's origin are sums over its chain of
    joints; a point p moves with `v + ω × p` and `a + α × p + ω × (v + ω × p)`.

    Args:
        J: (nv, 6) transposed world Jacobian of all joints, linear part first.
        parents: (njoints,) joint before each joint; joint 1 is the base, joint i the coordinate
            i + 4.
        joints: (k, 2) joints that move the points.
        points: (k, 2, 3) points in the world, m.
        normals: (k, 3) unit vectors from the first point to the second.
        v: (nv,) velocity.
        rows: (k, nv) to be written.
        bias: (k,) to be written, m/s².
    """
    chain = np.empty(parents.size, np.int64)
    velocity, acceleration = np.empty(6), np.empty(6)
    for i in range(joints.shape[0]):
        n0, n1, n2 = normals[i, 0], normals[i, 1], normals[i, 2]
        rows[i, :] = 0.0
        bias[i] = 0.0
        for side in range(2):
            sign = 2.0 * side - 1.0
            x, y, z = points[i, side, 0], points[i, side, 1], points[i, side, 2]
            m0, m1, m2 = y * n2 - z * n1, z * n0 - x * n2, x * n1 - y * n0  # p × n
            depth = 0
            joint = joints[i, side]
            while joint > 0:
                chain[depth] = joint
                depth += 1
                joint = parents[joint]
            for k in range(6):
                velocity[k] = acceleration[k] = 0.0
            for d in range(depth - 1, -1, -1):
                joint = chain[d]
                first, last = (0, 6) if joint == 1 else (joint + 4, joint + 5)
                for c in range(first, last):
                    rows[i, c] += sign * (
                        n0 * J[c, 0]
                        + n1 * J[c, 1]
                        + n2 * J[c, 2]
                        + m0 * J[c, 3]
                        + m1 * J[c, 4]
                        + m2 * J[c, 5]
                    )
                if joint > 1:
                    rate = v[last - 1]
                    x0, x1, x2 = J[first, 0] * rate, J[first, 1] * rate, J[first, 2] * rate
                    r0, r1, r2 = J[first, 3] * rate, J[first, 4] * rate, J[first, 5] * rate
                    u0, u1, u2, w0, w1, w2 = velocity
                    acceleration[0] += w1 * x2 - w2 * x1 + u1 * r2 - u2 * r1
                    acceleration[1] += w2 * x0 - w0 * x2 + u2 * r0 - u0 * r2
                    acceleration[2] += w0 * x1 - w1 * x0 + u0 * r1 - u1 * r0
                    acceleration[3] += w1 * r2 - w2 * r1
                    acceleration[4] += w2 * r0 - w0 * r2
                    acceleration[5] += w0 * r1 - w1 * r0
                for c in range(first, last):
                    for k in range(6):
                        velocity[k] += J[c, k] * v[c]
            u0, u1, u2, w0, w1, w2 = velocity
            v0, v1, v2 = u0 + w1 * z - w2 * y, u1 + w2 * x - w0 * z, u2 + w0 * y - w1 * x
            b0, b1, b2, b3, b4, b5 = acceleration
            bias[i] += sign * (
                n0 * (b0 + b4 * z - b5 * y + w1 * v2 - w2 * v1)
                + n1 * (b1 + b5 * x - b3 * z + w2 * v0 - w0 * v2)
                + n2 * (b2 + b3 * y - b4 * x + w0 * v1 - w1 * v0)
            )


@kernel(
    "int64(float64[:,:], int64[:,::1], int64[:,::1], float64[:,:,::1], float64[:,::1], "
    "float64[::1], float64[:,::1], int64[::1], int64, float64, int64[::1])"
)
def add_support_points(
    placements: np.ndarray,
    shapes: np.ndarray,
    joints: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    distances: np.ndarray,
    vertices: np.ndarray,
    starts: np.ndarray,
    count: int,
    depth: float,
    owner: np.ndarray,
) -> int:
    """Append to pairs of nearest points those vertices that are nearly as near to the other body.

    The plane through the one body's nearest point, with the normal of the distance, separates two
    convex bodies: no vertex of the other may pass it. A body held by its nearest point alone
    could turn about it.

    Args:
        placements: (njoints, 12), see `wbc.kinematics.Kinematics.joint_placements`.
        shapes: (m, 2) shapes of each pair; m rows, of which `count` are filled, likewise below.
        joints: (m, 2) joints that move them.
        points: (m, 2, 3) nearest points, m.
        normals: (m, 3) unit vectors from the first to the second.
        distances: (m,) m.
        vertices: (V, 3) vertices of all shapes in the axes of their joints, m.
        starts: (shapes + 1,) first vertex of each shape.
        count: number of pairs.
        depth: vertices are added that are at most that much farther than the nearest point, m.
        owner: (m,) to be written: the pair that each row belongs to.

    Returns:
        The number of rows.
    """
    total = count
    for i in range(count):
        owner[i] = i
    for i in range(count):
        n0, n1, n2 = normals[i, 0], normals[i, 1], normals[i, 2]
        for side in range(2):
            sign = 2.0 * side - 1.0
            T = placements[joints[i, side]]
            other = points[i, 1 - side]
            shape = shapes[i, side]
            for j in range(starts[shape], starts[shape + 1]):
                a, b, c = vertices[j, 0], vertices[j, 1], vertices[j, 2]
                x = T[0] * a + T[3] * b + T[6] * c + T[9]
                y = T[1] * a + T[4] * b + T[7] * c + T[10]
                z = T[2] * a + T[5] * b + T[8] * c + T[11]
                h = sign * (n0 * (x - other[0]) + n1 * (y - other[1]) + n2 * (z - other[2]))
                if h > distances[i] + depth or total >= owner.size:
                    continue
                near = points[i, side]
                u, v, w = x - near[0], y - near[1], z - near[2]
                if u * u + v * v + w * w < 2.5e-5:  # the nearest point itself, to 5 mm
                    continue
                points[total, side, 0], points[total, side, 1], points[total, side, 2] = x, y, z
                points[total, 1 - side, 0] = x - sign * h * n0
                points[total, 1 - side, 1] = y - sign * h * n1
                points[total, 1 - side, 2] = z - sign * h * n2
                normals[total, 0], normals[total, 1], normals[total, 2] = n0, n1, n2
                joints[total, 0], joints[total, 1] = joints[i, 0], joints[i, 1]
                distances[total] = h
                owner[total] = i
                total += 1
    return total

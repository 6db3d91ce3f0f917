"""One tick's quadratic program, from Pinocchio's passes to H, g, C, lb and ub, and back."""

from __future__ import annotations

import math

import numpy as np
from numba import types

from wbc.qp.kernels.groups import (
    MATRIX,
    VECTOR,
    Contacts,
    Frames,
    Limits,
    Maps,
    Program,
    Rows,
    Tasks,
    Tree,
    Wishes,
    group_type,
)
from wbc.qp.kernels.jit import kernel, part
from wbc.qp.kernels.motion import move_centroid, move_frames, sweep
from wbc.qp.kernels.rows import bound_joints, write_contacts, write_tasks


@part
def invert_action(X: np.ndarray, out: np.ndarray) -> None:
    """`[R, S; 0, R]⁻¹ = [Rᵀ, −Rᵀ S Rᵀ; 0, Rᵀ]`."""
    out[3:, :3] = 0.0
    for i in range(3):
        for j in range(3):
            out[i, j] = out[3 + i, 3 + j] = X[j, i]
    for i in range(3):
        for j in range(3):
            s = 0.0
            for k in range(3):
                for m in range(3):
                    s -= X[k, i] * X[k, 3 + m] * X[j, m]
            out[i, 3 + j] = s


@part
def eliminate(
    maps: Maps, M: np.ndarray, h: np.ndarray, J: np.ndarray, a: np.ndarray, unit: float
) -> None:
    """B, W, T of the elimination, see `wbc.qp.elimination`."""
    B, W, T, S, stance = maps.B, maps.W, maps.T, maps.S, maps.stance
    nv, nf = M.shape[0], J.shape[0]
    na, last = nv - 6, B.shape[1] - 1
    gone = 6 if stance.size > 0 else 0  # force components that are not unknowns
    X = np.empty((6, 6))
    if gone:
        invert_action(J[:6, :6], X)
        for i in range(6):
            for c in stance:
                s = 0.0
                for k in range(6):
                    s -= X[i, k] * J[k, 6 + c]
                B[i, c] = s
            s = 0.0
            for k in range(6):
                s += X[i, k] * a[k]
            B[i, last] = s
    # S: forces on the base at v̇_base = 0.
    for i in range(6):
        for c in range(na):
            S[i, c] = M[i, 6 + c]
        for f in range(gone, nf):
            S[i, na + f - gone] = -unit * J[f, i]
        S[i, last] = h[i]
    if not gone:
        solve_base(M, S, B)
    # With the base's motion. Without a stance contact S becomes zero: the base is free.
    for i in range(6):
        for k in range(6):
            m = M[i, k]
            for c in maps.dense:
                S[i, c] += m * B[k, c]
    for j in range(na):
        out = T[j]
        for c in range(na):
            out[c] = M[6 + j, 6 + c]
        for f in range(gone, nf):
            out[na + f - gone] = -unit * J[f, 6 + j]
        out[last] = h[6 + j]
        for k in range(6):
            m = M[6 + j, k]
            for c in maps.dense:
                out[c] += m * B[k, c]
    for j in stance:
        for k in range(6):
            p = B[k, j]
            for c in range(last + 1):
                T[j, c] += p * S[k, c]
    for i in range(gone):
        W[i, :] = 0.0
        for k in range(6):
            x = X[k, i]
            for c in range(last + 1):
                W[i, c] += x * S[k, c]


@part
def solve_base(M: np.ndarray, S: np.ndarray, B: np.ndarray) -> None:
    """B = −M_bb⁻¹ S."""
    L = np.empty((6, 6))
    for i in range(6):
        for j in range(i + 1):
            s = M[i, j]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = math.sqrt(s) if i == j else s / L[j, j]
    for i in range(6):
        B[i] = -S[i]
        for k in range(i):
            B[i] -= L[i, k] * B[k]
        B[i] /= L[i, i]
    for i in range(5, -1, -1):
        for k in range(i + 1, 6):
            B[i] -= L[k, i] * B[k]
        B[i] /= L[i, i]


@part
def project(rows: Rows, row: int, maps: Maps, out: np.ndarray) -> None:
    """out ← x̂'s coefficients of `A v̇` for one row of A."""
    na = maps.T.shape[0]
    out[:] = 0.0
    for c in range(na):
        out[c] = rows.A[row, 6 + c]
    for k in range(6):
        s = rows.A[row, k]
        if s != 0.0:
            for c in maps.dense:
                out[c] += s * maps.B[k, c]


@part
def write_cost(
    rows: Rows,
    maps: Maps,
    wishes: Wishes,
    program: Program,
    q: np.ndarray,
    v: np.ndarray,
    root_force: float,
) -> None:
    """H and g of `½ |G x̂|²`, small costs and the wishes for single joints."""
    G, H, g = program.G, program.H, program.g
    n, gone = g.size, 6 if maps.stance.size > 0 else 0
    count = G.shape[0] - gone
    for r in range(count):
        out, root = G[r], rows.root[r]
        project(rows, r, maps, out)
        out[n] -= rows.b[r]
        for c in range(n + 1):
            out[c] *= root
    for r in range(gone):
        for c in range(n + 1):
            G[count + r, c] = root_force * maps.W[r, c]
    g[:] = 0.0
    for i in range(n):
        H[i, : i + 1] = 0.0
        for r in range(G.shape[0]):
            s = G[r, i]
            for c in range(i + 1):
                H[i, c] += s * G[r, c]
            g[i] += s * G[r, n]
        H[i, i] += program.small[i]
    for i in range(wishes.joint.size):
        j = wishes.joint[i]
        kp, kd, weight = wishes.gain[0, i], wishes.gain[1, i], wishes.gain[2, i]
        wish = wishes.reference[1, i] + kd * (wishes.reference[0, i] - v[6 + j])
        wish += kp * (wishes.target[i] - q[7 + j])
        H[j, j] += weight
        g[j] -= weight * wish
    for i in range(n):
        for c in range(i):
            H[c, i] = H[i, c]


@part
def write_constraints(
    rows: Rows,
    maps: Maps,
    contacts: Contacts,
    limits: Limits,
    program: Program,
    q: np.ndarray,
    v: np.ndarray,
    unit: float,
) -> None:
    """C, lb and ub; the order of the rows as in `wbc.qp.constraints`."""
    C, lb, ub, W = program.C, program.lb, program.ub, maps.W
    n, na = C.shape[1], maps.T.shape[0]
    gone = 6 if maps.stance.size > 0 else 0
    bound_joints(limits, q, v, lb[:na], ub[:na])
    at = 0
    line = np.empty(n + 1)
    for r in range(program.G.shape[0] - gone, rows.b.size):
        project(rows, r, maps, line)
        C[at] = line[:n]
        lb[na + at] = ub[na + at] = rows.b[r] - line[n]
        at += 1
    for j in range(limits.torque.size):
        C[at] = maps.T[j, :n]
        lb[na + at] = -limits.torque[j] - maps.T[j, n]
        ub[na + at] = limits.torque[j] - maps.T[j, n]
        at += 1
    for i in range(contacts.place.shape[0]):
        start, size, count = contacts.place[i, 1], contacts.place[i, 2], contacts.place[i, 4]
        least, most = contacts.number[i, 1], contacts.number[i, 2]
        cone = contacts.cone[i]
        if start >= gone:  # the force is among the unknowns
            first = na + start - gone
            for r in range(count):
                for k in range(size):
                    C[at, first + k] = unit * cone[r, k]
                ub[na + at] = 0.0
                at += 1
            C[at, first + 2] = unit
            lb[na + at], ub[na + at] = least, most
        else:
            for r in range(count):
                line[:] = 0.0
                for k in range(size):
                    s = cone[r, k]
                    if s != 0.0:
                        for c in range(n + 1):
                            line[c] += s * W[start + k, c]
                C[at] = line[:n]
                ub[na + at] = -line[n]
                at += 1
            C[at] = W[start + 2, :n]
            lb[na + at] = least - W[start + 2, n]
            ub[na + at] = most - W[start + 2, n]
        at += 1


@kernel(
    types.boolean(
        MATRIX,
        VECTOR,
        MATRIX,
        VECTOR,
        VECTOR,
        *map(group_type, (Tree, Frames, Tasks, Wishes, Contacts)),
        *map(group_type, (Rows, Limits, Maps, Program)),
        types.float64,
        types.float64,
        types.float64,
    )
)
def assemble(
    M: np.ndarray,
    h: np.ndarray,
    J: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    tree: Tree,
    frames: Frames,
    tasks: Tasks,
    wishes: Wishes,
    contacts: Contacts,
    rows: Rows,
    limits: Limits,
    maps: Maps,
    program: Program,
    mass: float,
    unit: float,
    root_force: float,
) -> bool:
    """Write a tick's program.

    Args:
        M: (nv, nv) mass matrix, symmetric.
        h: (nv,) bias forces.
        J: (nv, 6) transposed world Jacobian of all joints.
        q, v: state.
        mass: kg.
        unit: of forces in x, N.
        root_force: root of the cost of an eliminated force, 1/N.

    Returns:
        Whether g and all bounds are numbers.
    """
    sweep(tree, J, v)
    move_frames(tree, frames, J)
    move_centroid(frames, M, h, v, mass, tree.gravity)
    write_tasks(tasks, frames, rows)
    write_contacts(contacts, frames, rows)
    eliminate(maps, M, h, contacts.J, contacts.a, unit)
    write_cost(rows, maps, wishes, program, q, v, root_force)
    write_constraints(rows, maps, contacts, limits, program, q, v, unit)
    total = 0.0
    for x in program.g:
        total += x
    if not math.isfinite(total):
        return False
    for i in range(program.lb.size):  # noqa: SIM110 - Numba compiles no generators
        if not program.ub[i] - program.lb[i] >= -1e300:
            return False
    return True


@kernel(types.boolean(VECTOR, VECTOR, VECTOR, group_type(Maps), VECTOR, types.float64, VECTOR))
def recover(
    x: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    maps: Maps,
    limit: np.ndarray,
    dt: float,
    out: np.ndarray,
) -> bool:
    """Write acceleration, torques, targets and forces one after the other.

    Args:
        x: (n,) solution.
        q, v: state.
        limit: (na,) torques are clipped to it (what the solver's tolerance leaves), or empty.
        dt: control period, s.
        out: (nv + 3 na + nf,) acceleration, torques, joint positions and velocities one period
            ahead, contact forces.

    Returns:
        Whether all of it is finite.
    """
    B, W, T = maps.B, maps.W, maps.T
    n, na, nf = x.size, T.shape[0], W.shape[0]
    nv = na + 6
    total = 0.0
    for i in range(6):
        s = B[i, n]
        for c in range(n):
            s += B[i, c] * x[c]
        out[i] = s
        total += s
    for j in range(na):
        s = T[j, n]
        for c in range(n):
            s += T[j, c] * x[c]
        if limit.size > 0:
            s = min(max(s, -limit[j]), limit[j])
        out[6 + j] = x[j]
        out[nv + j] = s
        out[nv + na + j] = q[7 + j] + dt * (v[6 + j] + 0.5 * dt * x[j])
        out[nv + 2 * na + j] = v[6 + j] + dt * x[j]
        total += s + x[j]
    for i in range(nf):
        s = W[i, n]
        for c in range(n):
            s += W[i, c] * x[c]
        out[nv + 3 * na + i] = s
        total += s
    return math.isfinite(total)

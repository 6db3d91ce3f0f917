"""One tick's quadratic program, from Pinocchio's passes to H, g, C, lb and ub, and back."""

from __future__ import annotations

import math

import numpy as np

from wbc.qp.kernels.elimination import add_product, eliminate, project
from wbc.qp.kernels.groups import Contacts, Limits, Maps, Program, Rows, Wishes
from wbc.qp.kernels.jit import kernel, part
from wbc.qp.kernels.motion import move_centroid, move_frames, sweep
from wbc.qp.kernels.rows import bound_joints, write_contacts, write_tasks
from wbc.qp.kernels.store import motion_groups, program_groups


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
    count = rows.cost[0]
    for r in range(count):
        out, root = G[r], rows.root[r]
        project(rows, r, maps, out)
        for c in range(n + 1):
            out[c] *= root
    for r in range(gone):
        for c in range(n + 1):
            G[count + r, c] = root_force * maps.W[r, c]
    for i in range(n):
        g[i] = 0.0
        for c in range(i + 1):
            H[i, c] = 0.0
        # By threes: most tasks have as many rows, and leave the columns of some limbs empty.
        for r in range(0, G.shape[0], 3):
            s0, s1, s2 = G[r, i], G[r + 1, i], G[r + 2, i]
            if s0 != 0.0 or s1 != 0.0 or s2 != 0.0:
                for c in range(i + 1):
                    H[i, c] += s0 * G[r, c] + s1 * G[r + 1, c] + s2 * G[r + 2, c]
                g[i] += s0 * G[r, n] + s1 * G[r + 1, n] + s2 * G[r + 2, n]
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
def split(line: np.ndarray, row: np.ndarray) -> float:
    """row ← the coefficients of x in a row of x̂'s; returns the constant behind them."""
    for c in range(row.size):
        row[c] = line[c]
    constant: float = line[row.size]
    return constant


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
    for r in range(rows.cost[0], rows.b.size):
        project(rows, r, maps, line)
        lb[na + at] = ub[na + at] = -split(line, C[at])
        at += 1
    for j in range(limits.torque.size):
        constant = split(maps.T[j], C[at])
        lb[na + at], ub[na + at] = -limits.torque[j] - constant, limits.torque[j] - constant
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
                for c in range(n + 1):
                    line[c] = 0.0
                add_product(cone[r], W[start:], line)
                ub[na + at] = -split(line, C[at])
                at += 1
            constant = split(W[start + 2], C[at])
            lb[na + at], ub[na + at] = least - constant, most - constant
        at += 1


@kernel(
    "boolean(float64[:,::1], float64[::1], float64[:,::1], float64[::1], float64[::1], "
    "float64[::1], int64[::1], int64[:,::1], float64, float64, float64)"
)
def assemble(
    M: np.ndarray,
    h: np.ndarray,
    J: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    reals: np.ndarray,
    integers: np.ndarray,
    table: np.ndarray,
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
        reals, integers, table: the arrays of a `Store`.
        mass: kg.
        unit: of forces in x, N.
        root_force: root of the cost of an eliminated force, 1/N.

    Returns:
        Whether g and all bounds are numbers.
    """
    tree, frames, tasks, wishes, contacts = motion_groups(reals, integers, table)
    rows, limits, maps, program = program_groups(reals, integers, table)
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


@kernel(
    "boolean(float64[::1], float64[::1], float64[::1], float64[::1], int64[::1], int64[:,::1], "
    "float64, float64[::1])"
)
def recover(
    x: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    reals: np.ndarray,
    integers: np.ndarray,
    table: np.ndarray,
    dt: float,
    out: np.ndarray,
) -> bool:
    """Write acceleration, torques, targets and forces one after the other.

    Args:
        x: (n,) solution.
        q, v: state.
        reals, integers, table: the arrays of a `Store`.
        dt: control period, s.
        out: (nv + 3 na + nf,) acceleration, torques, clipped to their limits (what the solver's
            tolerance leaves), joint positions and velocities one period ahead, contact forces.

    Returns:
        Whether all of it is finite.
    """
    _, limits, maps, _ = program_groups(reals, integers, table)
    B, W, T, limit = maps.B, maps.W, maps.T, limits.torque
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

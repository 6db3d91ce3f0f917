"""One tick's quadratic program, from Pinocchio's passes to H, g, C, lb and ub, and back."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import kernel, subkernel
from wbc.qp.kernels.buffers import (
    read_bounds,
    read_contacts,
    read_frames,
    read_inequalities,
    read_joint_tasks,
    read_maps,
    read_motion_tasks,
    read_program,
    read_rows,
    read_tree,
)
from wbc.qp.kernels.elimination import add_product, eliminate, project
from wbc.qp.kernels.groups import (
    AffineMaps,
    Contacts,
    DenseRows,
    Inequalities,
    JointBounds,
    JointTasks,
    QuadraticProgram,
)
from wbc.qp.kernels.motion import move_centroid, move_frames, place_frames, sweep
from wbc.qp.kernels.rows import write_contacts, write_joint_bounds, write_tasks


@subkernel
def write_cost(
    rows: DenseRows,
    maps: AffineMaps,
    joint_tasks: JointTasks,
    program: QuadraticProgram,
    q: np.ndarray,
    v: np.ndarray,
    first: int,
    root_force: float,
) -> None:
    """Write G, and H and g of `½ |G x̂|²` of the last level, of its tasks on single joints and of
    the regularisation.
    """
    G, H, g = program.G, program.H, program.g
    n, eliminated = g.size, 6 if maps.stance_joints.size > 0 else 0
    count = rows.root_weight.size
    for r in range(count):
        out, root = G[r], rows.root_weight[r]
        project(rows.A[r], -rows.b[r], maps, out)
        for c in range(n + 1):
            out[c] *= root
    for r in range(eliminated):
        for c in range(n + 1):
            G[count + r, c] = root_force * maps.W[r, c]
    for i in range(n):
        g[i] = 0.0
        for c in range(i + 1):
            H[i, c] = 0.0
        # By threes: most tasks have as many rows, and leave the columns of some limbs empty.
        for r in range(first, G.shape[0], 3):
            s0, s1, s2 = G[r, i], G[r + 1, i], G[r + 2, i]
            if s0 != 0.0 or s1 != 0.0 or s2 != 0.0:
                for c in range(i + 1):
                    H[i, c] += s0 * G[r, c] + s1 * G[r + 1, c] + s2 * G[r + 2, c]
                g[i] += s0 * G[r, n] + s1 * G[r + 1, n] + s2 * G[r + 2, n]
        H[i, i] += program.regularisation[i]
    for i in range(joint_tasks.joint.size):
        j, weight = joint_tasks.joint[i], joint_tasks.weight[i]
        b = joint_tasks.acceleration[i] + joint_tasks.kd[i] * (joint_tasks.velocity[i] - v[6 + j])
        b += joint_tasks.kp[i] * (joint_tasks.target[i] - q[7 + j])
        H[j, j] += weight
        g[j] -= weight * b
    for i in range(n):
        for c in range(i):
            H[c, i] = H[i, c]


@subkernel
def split(affine: np.ndarray, row: np.ndarray) -> float:
    """row ← the coefficients of x in a row of x̂'s; returns the constant behind them."""
    for c in range(row.size):
        row[c] = affine[c]
    constant: float = affine[row.size]
    return constant


@subkernel
def write_limit_rows(
    inequalities: Inequalities, maps: AffineMaps, program: QuadraticProgram, first: int
) -> None:
    """Write the rows of the general limits, from row `first` of C on."""
    n, na = program.C.shape[1], maps.T.shape[0]
    affine = np.empty(n + 1)
    for r in range(inequalities.lower.size):
        project(inequalities.A[r], 0.0, maps, affine)
        for k in range(maps.W.shape[0]):
            coefficient = inequalities.F[r, k]
            if coefficient != 0.0:
                for c in range(n + 1):
                    affine[c] += coefficient * maps.W[k, c]
        row = first + r
        constant = split(affine, program.C[row])
        program.lb[na + row] = inequalities.lower[r] - constant
        program.ub[na + row] = inequalities.upper[r] - constant


@subkernel
def write_force_rows(
    contacts: Contacts, maps: AffineMaps, program: QuadraticProgram, first: int, unit: float
) -> None:
    """Write the rows of the force cones and normal forces, from row `first` of C on."""
    C, lb, ub, W = program.C, program.lb, program.ub, maps.W
    n, na = C.shape[1], maps.T.shape[0]
    eliminated = 6 if maps.stance_joints.size > 0 else 0
    affine = np.empty(n + 1)
    row = first
    for i in range(contacts.frame.size):
        start, size = contacts.force[i], contacts.size[i]
        cone = contacts.cone[contacts.cone_row[i] : contacts.cone_row[i] + contacts.cone_size[i]]
        least, most = contacts.min_force[i], contacts.max_force[i]
        if start >= eliminated:  # the force is among the unknowns
            column = na + start - eliminated
            for r in range(cone.shape[0]):
                for k in range(size):
                    C[row, column + k] = unit * cone[r, k]
                ub[na + row] = 0.0
                row += 1
            C[row, column + 2] = unit
            lb[na + row], ub[na + row] = least, most
        else:
            for r in range(cone.shape[0]):
                for c in range(n + 1):
                    affine[c] = 0.0
                add_product(cone[r], W[start:], affine)
                ub[na + row] = -split(affine, C[row])
                row += 1
            constant = split(W[start + 2], C[row])
            lb[na + row], ub[na + row] = least - constant, most - constant
        row += 1


@subkernel
def write_constraints(
    rows: DenseRows,
    maps: AffineMaps,
    contacts: Contacts,
    bounds: JointBounds,
    inequalities: Inequalities,
    program: QuadraticProgram,
    q: np.ndarray,
    v: np.ndarray,
    unit: float,
) -> None:
    """Write C, lb and ub; the order of the rows is that of `wbc.qp.constraints`."""
    C, lb, ub = program.C, program.lb, program.ub
    n, na = C.shape[1], maps.T.shape[0]
    write_joint_bounds(bounds, q, v, lb[:na], ub[:na])
    row = 0
    affine = np.empty(n + 1)
    for r in range(rows.root_weight.size, rows.b.size):
        project(rows.A[r], -rows.b[r], maps, affine)
        lb[na + row] = ub[na + row] = -split(affine, C[row])
        row += 1
    for j in range(bounds.torque.size):
        limit = bounds.torque[j]
        constant = split(maps.T[j], C[row])
        lb[na + row], ub[na + row] = -limit - constant, limit - constant
        row += 1
    write_limit_rows(inequalities, maps, program, row)
    write_force_rows(contacts, maps, program, row + inequalities.lower.size, unit)


@kernel(
    "boolean(float64[:,::1], float64[::1], float64[:,::1], float64[:,::1], float64[::1], "
    "float64[::1], float64[::1], int64[::1], int64[:,::1], int64, float64, float64, float64)"
)
def assemble(
    M: np.ndarray,
    h: np.ndarray,
    J: np.ndarray,
    joint_placements: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    reals: np.ndarray,
    integers: np.ndarray,
    table: np.ndarray,
    first: int,
    mass: float,
    unit: float,
    root_force: float,
) -> bool:
    """Write a tick's program.

    Args:
        M: (nv, nv) mass matrix, symmetric.
        h: (nv,) bias forces.
        J: (nv, 6) transposed world Jacobian of all joints.
        joint_placements: (njoints, 12), see `wbc.kinematics.Kinematics`.
        q, v: state.
        reals, integers, table: the arrays of a `Buffers`.
        first: first row of the last level among those of the cost.
        mass: kg.
        unit: unit of forces in x, N.
        root_force: root of the cost of an eliminated force, 1/N.

    Returns:
        Whether the rows of the upper levels, g and all bounds are numbers.
    """
    tree = read_tree(reals, integers, table)
    frames = read_frames(reals, integers, table)
    contacts = read_contacts(reals, integers, table)
    rows = read_rows(reals, integers, table)
    maps = read_maps(reals, integers, table)
    program = read_program(reals, integers, table)
    sweep(tree, J, v)
    place_frames(frames, joint_placements)
    move_frames(tree, frames, J)
    move_centroid(frames, M, h, v, mass, tree.gravity)
    write_tasks(read_motion_tasks(reals, integers, table), frames, rows)
    write_contacts(contacts, frames, rows)
    eliminate(maps, M, h, contacts.jacobian, contacts.acceleration, unit)
    joint_tasks = read_joint_tasks(reals, integers, table)
    write_cost(rows, maps, joint_tasks, program, q, v, first, root_force)
    bounds = read_bounds(reals, integers, table)
    inequalities = read_inequalities(reals, integers, table)
    write_constraints(rows, maps, contacts, bounds, inequalities, program, q, v, unit)
    total = 0.0
    for r in range(first):
        for x in program.G[r]:
            total += x
    for x in program.g:
        total += x
    if not math.isfinite(total):
        return False
    for i in range(program.lb.size):  # noqa: SIM110 - Numba compiles no generators
        if not program.ub[i] - program.lb[i] >= -1e300:
            return False
    return True


@kernel(
    "boolean(float64[::1], float64[::1], float64[::1], int64[::1], int64[:,::1], "
    "float64, float64[::1])"
)
def recover(
    q: np.ndarray,
    v: np.ndarray,
    reals: np.ndarray,
    integers: np.ndarray,
    table: np.ndarray,
    dt: float,
    out: np.ndarray,
) -> bool:
    """Write acceleration, torques, targets and forces of the solution, one after the other.

    Args:
        q, v: state.
        reals, integers, table: the arrays of a `Buffers`.
        dt: control period, s.
        out: (nv + 3 na + nf,) acceleration, torques, clipped to their limits (what the solver's
            tolerance leaves), joint positions and velocities one period ahead, contact forces.

    Returns:
        Whether all of it is finite.
    """
    maps = read_maps(reals, integers, table)
    limit = read_bounds(reals, integers, table).torque
    x = read_program(reals, integers, table).x
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

"""The quadratic program of inverse kinematics, from Pinocchio's Jacobians to H and C."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, NamedTuple

import numpy as np

from wbc.jit.compile import kernel, subkernel
from wbc.qp.kernels.groups import DenseRows, Frames, JointTasks, MotionTasks, Tree
from wbc.qp.kernels.motion import move_centroid, move_frames, place_frames
from wbc.qp.kernels.rows import write_tasks
from wbc.qp.kernels.schema import Memory, integers, reader, reals


class VelocityConstraints(NamedTuple):
    """Limits on joints and general ones, see `wbc.ik`.

    Attributes:
        lower: least position, rad.
        upper: largest position, rad.
        braking: rad/s², infinite for none.
        least: least velocity by other limits, rad/s.
        most: largest velocity by other limits, rad/s.
        jerk_least: least velocity by limits on jerks, rad/s, where the others leave a choice.
        jerk_most: largest velocity by limits on jerks, rad/s.
        A: coefficients of the general limits.
        low: their least value.
        high: their largest value.
    """

    lower: Annotated[np.ndarray, reals("joints")]
    upper: Annotated[np.ndarray, reals("joints")]
    braking: Annotated[np.ndarray, reals("joints")]
    least: Annotated[np.ndarray, reals("joints")]
    most: Annotated[np.ndarray, reals("joints")]
    jerk_least: Annotated[np.ndarray, reals("joints")]
    jerk_most: Annotated[np.ndarray, reals("joints")]
    A: Annotated[np.ndarray, reals("limit_rows", "velocities")]
    low: Annotated[np.ndarray, reals("limit_rows")]
    high: Annotated[np.ndarray, reals("limit_rows")]


class VelocityQp(NamedTuple):
    """The quadratic program, see `wbc.qp.problem`.

    Attributes:
        columns: coordinates that move, joints first.
        G: weighted residuals of the cost; some rows at the end stay empty, to make their number
            a multiple of three.
        H, g, C, lb, ub: see `Problem`.
        zero: (nv,) zeros.
    """

    columns: Annotated[np.ndarray, integers("unknowns")]
    G: Annotated[np.ndarray, reals("residual_rows", "affine")]
    H: Annotated[np.ndarray, reals("unknowns", "unknowns")]
    g: Annotated[np.ndarray, reals("unknowns")]
    C: Annotated[np.ndarray, reals("constraint_rows", "unknowns")]
    lb: Annotated[np.ndarray, reals("bound_rows")]
    ub: Annotated[np.ndarray, reals("bound_rows")]
    zero: Annotated[np.ndarray, reals("velocities")]


_GROUPS: tuple[type, ...] = (
    Tree,
    Frames,
    MotionTasks,
    JointTasks,
    DenseRows,
    VelocityConstraints,
    VelocityQp,
)


@dataclass(frozen=True)
class VelocitySizes:
    """The lengths of all axes, for one structure of the program.

    Attributes:
        joints: actuated joints, na.
        unknowns: coordinates that move, n.
        frames: frames that tasks refer to, the centroid among them.
        motion_tasks: tasks on components of a frame's motion.
        joint_rows: rows of weighted tasks on single joints.
        dense_rows: rows of all other tasks.
        cost_rows: how many of them are in the cost.
        limit_rows: rows of general limits.
    """

    joints: int
    unknowns: int
    frames: int
    motion_tasks: int
    joint_rows: int
    dense_rows: int
    cost_rows: int
    limit_rows: int

    @cached_property
    def bodies(self) -> int:
        """The base and one body per joint."""
        return self.joints + 1

    @cached_property
    def velocities(self) -> int:
        """Size of the generalised velocity, nv."""
        return self.joints + 6

    @cached_property
    def affine(self) -> int:
        """Size of (x, 1)."""
        return self.unknowns + 1

    @cached_property
    def residual_rows(self) -> int:
        """Rows of the cost's residual, a multiple of three."""
        return -3 * (-self.cost_rows // 3)

    @cached_property
    def constraint_rows(self) -> int:
        """Rows of C."""
        return self.dense_rows - self.cost_rows + self.limit_rows

    @cached_property
    def bound_rows(self) -> int:
        """Size of lb and ub."""
        return self.unknowns + self.constraint_rows


class VelocityBuffers:
    """The memory of one structure of the program; attributes as `arrays` see `Memory`."""

    def __init__(self, sizes: VelocitySizes) -> None:
        memory = Memory(_GROUPS, sizes)
        self.arrays = memory.arrays
        self.tree = memory.group(Tree)
        self.frames = memory.group(Frames)
        self.motion_tasks = memory.group(MotionTasks)
        self.joint_tasks = memory.group(JointTasks)
        self.rows = memory.group(DenseRows)
        self.limits = memory.group(VelocityConstraints)
        self.program = memory.group(VelocityQp)


_read_tree = reader(_GROUPS, Tree)
_read_frames = reader(_GROUPS, Frames)
_read_motion_tasks = reader(_GROUPS, MotionTasks)
_read_joint_tasks = reader(_GROUPS, JointTasks)
_read_rows = reader(_GROUPS, DenseRows)
_read_limits = reader(_GROUPS, VelocityConstraints)
_read_program = reader(_GROUPS, VelocityQp)


@subkernel
def stopping_speed(distance: float, braking: float, dt: float, recovery: float) -> float:
    """Return the largest speed towards a limit, see `wbc.limits.position.stopping_speed`."""
    if distance < 0.0:
        return distance / max(recovery, dt)
    unit = braking * dt * dt
    # Not `isfinite`, which is `x − x == 0` to the compiler: it may reorder the sums, also those
    # that the distance comes from, and took an infinite one for finite.
    if unit == math.inf or distance == math.inf:
        return distance / dt
    k = math.floor(0.5 * (math.sqrt(1.0 + 8.0 * distance / unit) - 1.0))
    return distance / ((k + 1.0) * dt) + 0.5 * k * unit / dt


@subkernel
def write_velocity_cost(
    rows: DenseRows, tasks: JointTasks, program: VelocityQp, q: np.ndarray, damping: float
) -> None:
    """Write H and g."""
    G, H, g, columns = program.G, program.H, program.g, program.columns
    n = g.size
    for r in range(rows.root_weight.size):
        root = rows.root_weight[r]
        for c in range(n):
            G[r, c] = root * rows.A[r, columns[c]]
        G[r, n] = -root * rows.b[r]
    for i in range(n):
        g[i] = 0.0
        for c in range(i + 1):
            H[i, c] = 0.0
        for r in range(0, G.shape[0], 3):
            s0, s1, s2 = G[r, i], G[r + 1, i], G[r + 2, i]
            if s0 != 0.0 or s1 != 0.0 or s2 != 0.0:
                for c in range(i + 1):
                    H[i, c] += s0 * G[r, c] + s1 * G[r + 1, c] + s2 * G[r + 2, c]
                g[i] += s0 * G[r, n] + s1 * G[r + 1, n] + s2 * G[r + 2, n]
        H[i, i] += damping
    # Joints are the first unknowns, in ascending order, but some of them may be held.
    for i in range(tasks.joint.size):
        j, weight = tasks.joint[i], tasks.weight[i]
        if j >= 0:
            dof = columns[j] - 6
            b = tasks.velocity[i] + tasks.kp[i] * (tasks.target[i] - q[7 + dof])
            H[j, j] += weight
            g[j] -= weight * b
    for i in range(n):
        for c in range(i):
            H[c, i] = H[i, c]


@subkernel
def write_velocity_constraints(
    rows: DenseRows,
    limits: VelocityConstraints,
    program: VelocityQp,
    q: np.ndarray,
    dt: float,
    recovery: float,
) -> None:
    """Write C, lb and ub: bounds of the unknowns, exact tasks, general limits."""
    C, lb, ub, columns = program.C, program.lb, program.ub, program.columns
    n = columns.size
    for i in range(n):
        j = columns[i] - 6
        if j < 0:
            lb[i], ub[i] = -np.inf, np.inf
            continue
        braking = limits.braking[j]
        low = -stopping_speed(q[7 + j] - limits.lower[j], braking, dt, recovery)
        high = stopping_speed(limits.upper[j] - q[7 + j], braking, dt, recovery)
        least, most = limits.least[j], limits.most[j]
        low, high = min(max(low, least), most), min(max(high, least), most)
        lb[i] = min(max(limits.jerk_least[j], low), high)
        ub[i] = min(max(limits.jerk_most[j], low), high)
    row, first = n, rows.root_weight.size
    for r in range(first, rows.b.size):
        for c in range(n):
            C[row - n, c] = rows.A[r, columns[c]]
        lb[row] = ub[row] = rows.b[r]
        row += 1
    for r in range(limits.low.size):
        for c in range(n):
            C[row - n, c] = limits.A[r, columns[c]]
        lb[row], ub[row] = limits.low[r], limits.high[r]
        row += 1


@kernel(
    "boolean(float64[:,::1], float64[:,::1], float64[:,::1], float64[::1], float64[::1], "
    "int64[::1], int64[:,::1], boolean, float64, float64, float64, float64)"
)
def assemble_velocity(
    M: np.ndarray,
    J: np.ndarray,
    joint_placements: np.ndarray,
    q: np.ndarray,
    real_arrays: np.ndarray,
    integer_arrays: np.ndarray,
    table: np.ndarray,
    with_centroid: bool,
    mass: float,
    damping: float,
    dt: float,
    recovery: float,
) -> bool:
    """Write the program of a step.

    Args:
        M: (nv, nv) mass matrix; anything when no task is about the centroid.
        J: (nv, 6) transposed world Jacobian of all joints.
        joint_placements: (njoints, 12), see `wbc.kinematics.Kinematics`.
        q: (nq,) configuration.
        real_arrays, integer_arrays, table: the arrays of `VelocityBuffers`.
        with_centroid: whether a task is about the centroid.
        mass: kg.
        damping: cost of each unknown.
        dt: duration of the step, s.
        recovery: time within which a joint beyond its limit is brought back, s.

    Returns:
        Whether g and all bounds are numbers.
    """
    frames = _read_frames(real_arrays, integer_arrays, table)
    tree = _read_tree(real_arrays, integer_arrays, table)
    rows = _read_rows(real_arrays, integer_arrays, table)
    program = _read_program(real_arrays, integer_arrays, table)
    place_frames(frames, joint_placements)
    move_frames(tree, frames, J)  # the bodies are at rest: their velocities are zero
    if with_centroid:
        move_centroid(frames, M, program.zero, program.zero, mass, tree.gravity)
    write_tasks(_read_motion_tasks(real_arrays, integer_arrays, table), frames, rows)
    joint_tasks = _read_joint_tasks(real_arrays, integer_arrays, table)
    write_velocity_cost(rows, joint_tasks, program, q, damping)
    limits = _read_limits(real_arrays, integer_arrays, table)
    write_velocity_constraints(rows, limits, program, q, dt, recovery)
    total = 0.0
    for x in program.g:
        total += x
    for r in range(rows.root_weight.size, rows.b.size):
        total += rows.b[r]
    if not math.isfinite(total):
        return False
    for i in range(program.lb.size):  # noqa: SIM110 - Numba compiles no generators
        if not program.ub[i] - program.lb[i] >= -1e300:
            return False
    return True

"""The compiled velocity program: copies what tasks and limits ask for, and calls the kernel.

The same QP as `wbc.ik.velocity_program` makes with numpy; the tests compare the two. Tasks of
other classes than the library's own write their rows in Python, as there.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import TypeGuard

import numpy as np

from wbc.ik.configuration_kinematics import ConfigurationKinematics
from wbc.ik.velocity_program import (
    Unknown,
    VelocityProblemLayout,
    limit_update,
    postures_last,
)
from wbc.limits import (
    AccelerationBound,
    JointJerkLimit,
    JointPositionLimit,
    JointVelocityLimit,
)
from wbc.qp import Problem
from wbc.qp.kernels.velocity import VelocityBuffers, VelocitySizes, assemble_velocity
from wbc.qp.row_errors import raise_row_error
from wbc.tasks import AngularMomentumTask, MotionTask, PostureTask, Task, TaskReference
from wbc.tasks.motion import CENTROID

_Update = Callable[[ConfigurationKinematics], None]


class CompiledVelocityProgram:
    """Builds the QP of one layout in compiled code; see `VelocityProgram`."""

    def __init__(self, layout: VelocityProblemLayout) -> None:
        self._layout = layout
        robot, limits, columns = layout.robot, layout.limits, layout.columns
        joint_tasks = [t for t in layout.weighted if _is_plain_posture(t)]
        in_cost = [t for t in postures_last(layout.weighted) if t not in joint_tasks]
        dense = [*in_cost, *layout.exact]
        motion_tasks = [t for t in dense if isinstance(t, MotionTask) and _has_kernel(t)]
        ids = dict.fromkeys(t.frame_id for t in motion_tasks)
        self._with_centroid = CENTROID in ids
        ids.pop(CENTROID, None)
        frames = [robot.model.frames[i] for i in ids]
        cost_rows = sum(t.size for t in in_cost)
        self._buffers = buffers = VelocityBuffers(
            VelocitySizes(
                joints=robot.na,
                unknowns=columns.size,
                frames=len(frames) + 1,
                motion_tasks=len(motion_tasks),
                joint_rows=sum(t.size for t in joint_tasks),
                dense_rows=sum(t.size for t in dense),
                cost_rows=cost_rows,
                limit_rows=sum(limit.size for limit in limits.inequalities),
            )
        )
        model, na = robot.model, robot.na
        buffers.tree.parent[:] = [max(model.parents[i] - 1, 0) for i in range(1, na + 2)]
        buffers.frames.body[1:] = [frame.parentJoint - 1 for frame in frames]
        for k, frame in enumerate(frames, 1):
            buffers.frames.in_body[k] = frame.placement.homogeneous
        buffers.frames.in_body[0] = np.eye(4)
        buffers.program.columns[:] = columns
        self._updates: list[tuple[object, _Update]] = []
        self._q = robot.q_nominal
        self._posture_joints = np.array([j for t in joint_tasks for j in t.index], dtype=int)
        row = k = 0
        for task in dense:
            if task in motion_tasks:
                assert isinstance(task, MotionTask)
                frame = 0 if task.frame_id == CENTROID else 1 + list(ids).index(task.frame_id)
                update = _motion_update(task, layout, buffers, k, frame, row)
                k += 1
            else:
                update = _dense_update(task, layout, buffers, row)
            self._updates.append((task, update))
            row += task.size
        row = 0
        for joint_task in joint_tasks:
            part = slice(row, row + joint_task.size)
            self._updates.append((joint_task, _posture_update(joint_task, layout, buffers, part)))
            row += joint_task.size
        self._limit_updates = []
        row = 0
        for limit in limits.inequalities:
            part = slice(row, row + limit.size)
            group = buffers.limits
            self._limit_updates.append(
                limit_update(limit, group.A[part], group.low[part], group.high[part])
            )
            row += limit.size
        self._bounds = _JointBounds(layout, buffers)
        program = buffers.program
        equality = np.zeros(program.lb.size, dtype=bool)
        equality[columns.size : columns.size + sum(t.size for t in layout.exact)] = True
        self._problem = Problem(
            program.H,
            program.g,
            program.C,
            program.lb,
            program.ub,
            columns.size,
            equality,
            layout.blocks(),
        )
        self._no_mass_matrix = np.zeros((1, 1))
        self._errors = np.zeros(cost_rows + sum(t.size for t in joint_tasks))

    @property
    def errors(self) -> np.ndarray:
        """See `VelocityProgram`."""
        postures = self._errors.size - self._buffers.rows.root_weight.size
        split = self._errors.size - postures
        self._errors[:split] = self._buffers.rows.b[:split]
        if postures:
            group, q = self._buffers.joint_tasks, self._q
            self._errors[split:] = group.target - q[7:][self._posture_joints]
        return self._errors

    def build(self, kin: ConfigurationKinematics, v: np.ndarray, dt: float) -> Problem:
        """See `VelocityProgram.build`; its arrays are valid until the next call."""
        owner: object = None
        self._q = kin.state.q
        try:
            for owner, update in self._updates:  # noqa: B007 - named when it fails
                update(kin)
        except (ValueError, TypeError, AttributeError) as error:
            raise_row_error(owner, error)
        for update_limit in self._limit_updates:
            update_limit(kin, dt)
        self._bounds.update(kin, v, dt)
        self._problem.finite = assemble_velocity(
            kin.mass_matrix if self._with_centroid else self._no_mass_matrix,
            kin.data.J.T,
            kin.joint_placements,
            kin.state.q,
            *self._buffers.arrays,
            self._with_centroid,
            kin.mass,
            self._layout.damping,
            dt,
            self._bounds.recovery,
        )
        return self._problem


def _is_plain_posture(task: Task) -> TypeGuard[PostureTask]:
    """Return whether this is a posture whose velocity form is the library's own."""
    own = PostureTask.write_velocity
    return isinstance(task, PostureTask) and type(task).write_velocity is own


def _has_kernel(task: MotionTask) -> bool:
    """Return whether the kernel writes this task's rows; otherwise it writes them itself."""
    written = type(task).write_velocity
    return written in (MotionTask.write_velocity, AngularMomentumTask.write_velocity)


def _motion_update(
    task: MotionTask,
    layout: VelocityProblemLayout,
    buffers: VelocityBuffers,
    k: int,
    frame: int,
    row: int,
) -> _Update:
    """Update of the k-th motion task, whose rows start at `row`.

    The kernel writes `kd (velocity − 0) + kp e`: with kd = 1 and kp = kp/kd that is the velocity.
    """
    group, part = buffers.motion_tasks, task.components
    group.frame[k], group.component[k] = frame, part.start
    group.size[k], group.row[k] = task.size, row
    group.target[k] = np.eye(4)
    unused = np.zeros(task.size)  # feed-forward accelerations have no meaning here
    reference = TaskReference(group.target[k], group.velocity[k, part], unused)
    kp, kd = group.kp[k, part], group.kd[k, part]
    root_weight = buffers.rows.root_weight[row : row + task.size]
    displacement = layout.unknown is Unknown.DISPLACEMENT
    momentum = isinstance(task, AngularMomentumTask)
    kd[:] = 0.0 if displacement or momentum else 1.0
    kp[:] = 0.0 if displacement and momentum else 1.0
    gains: object = None

    def update(kin: ConfigurationKinematics) -> None:
        nonlocal gains
        task.write_reference(kin, reference)
        if gains is not task.gains:
            gains = task.gains
            if not (displacement or momentum):
                kp[:] = task.velocity_gain
            root_weight[:] = task.sqrt_weight[: root_weight.size]

    return update


def _dense_update(
    task: Task, layout: VelocityProblemLayout, buffers: VelocityBuffers, row: int
) -> _Update:
    """Update of a task that writes its rows itself."""
    rows, part = buffers.rows, slice(row, row + task.size)
    A, b, root_weight = rows.A[part], rows.b[part], rows.root_weight[part]
    velocity, error = np.zeros((2, task.size))

    def update(kin: ConfigurationKinematics) -> None:
        task.write_velocity(kin, A, velocity, error)
        if layout.unknown is Unknown.DISPLACEMENT:
            b[:] = error
        else:
            np.multiply(task.velocity_gain, error, out=b)
            b[:] += velocity
        root_weight[:] = task.sqrt_weight[: root_weight.size]

    return update


def _posture_update(
    task: PostureTask, layout: VelocityProblemLayout, buffers: VelocityBuffers, part: slice
) -> _Update:
    """Update of a posture; joints that do not move are left out by the index −1."""
    group, unknowns = buffers.joint_tasks, list(layout.joints)
    group.joint[part] = [unknowns.index(j) if j in unknowns else -1 for j in task.index]
    target, velocity = group.target[part], group.velocity[part]
    kp, weight = group.kp[part], group.weight[part]
    displacement = layout.unknown is Unknown.DISPLACEMENT
    gains: object = None

    def update(kin: ConfigurationKinematics) -> None:
        nonlocal gains
        target[:] = task.target
        if not displacement:
            velocity[:] = task.velocity
        if gains is not task.gains:
            gains = task.gains
            kp[:] = 1.0 if displacement else task.velocity_gain
            weight[:] = task.weight

    return update


class _JointBounds:
    """Limits on joints: positions in the kernel, the others combined here when they change.

    Attributes:
        recovery: time within which a joint beyond its limit is brought back, s.
    """

    def __init__(self, layout: VelocityProblemLayout, buffers: VelocityBuffers) -> None:
        self._group = buffers.limits
        self._positions = [b for b in layout.limits.bounds if _is_plain_position_limit(b)]
        self._jerks = [b for b in layout.limits.bounds if isinstance(b, JointJerkLimit)]
        own = [*self._positions, *self._jerks]
        self._others = [b for b in layout.limits.bounds if b not in own]
        self._velocities = [b for b in self._others if type(b) is JointVelocityLimit]
        self._constant = len(self._velocities) == len(self._others)
        self._copied: list[object] | None = None
        self.recovery = 0.2
        buffers.limits.jerk_least[:], buffers.limits.jerk_most[:] = -np.inf, np.inf

    def update(self, kin: ConfigurationKinematics, v: np.ndarray, dt: float) -> None:
        """Write the bounds of this step; arrays that cannot change in place are copied once."""
        present: list[object] = []
        for position in self._positions:
            present += _position_arrays(position)
        for velocity in self._velocities:
            present.append(velocity.maximum)
        copied = self._copied
        unchanged = copied is not None and all(map(operator.is_, present, copied))
        if not unchanged:
            fixed = all(isinstance(x, float) or not x.flags.writeable for x in present)  # type: ignore[attr-defined]
            self._copied = present if fixed else None
            self._copy_positions()
        group = self._group
        if not (unchanged and self._constant):
            self._combine(self._others, group.least, group.most, kin, v, dt)
        if self._jerks:
            self._combine(self._jerks, group.jerk_least, group.jerk_most, kin, v, dt)

    @staticmethod
    def _combine(
        bounds: Sequence[AccelerationBound],
        least: np.ndarray,
        most: np.ndarray,
        kin: ConfigurationKinematics,
        v: np.ndarray,
        dt: float,
    ) -> None:
        """Write the tightest bounds; where two exclude each other the first holds."""
        least[:], most[:] = -np.inf, np.inf
        for bound in bounds:
            low, high = bound.velocity_bounds(kin, v, dt)
            before = least.copy(), most.copy()
            least[:], most[:] = low.clip(*before), high.clip(*before)

    def _copy_positions(self) -> None:
        group = self._group
        group.lower[:], group.upper[:], group.braking[:] = -np.inf, np.inf, np.inf
        for position in self._positions:
            np.maximum(group.lower, position.lower, out=group.lower)
            np.minimum(group.upper, position.upper, out=group.upper)
            np.minimum(group.braking, position.braking, out=group.braking)
            self.recovery = position.recovery


_position_arrays = operator.attrgetter("lower", "upper", "braking", "recovery")


def _is_plain_position_limit(bound: object) -> TypeGuard[JointPositionLimit]:
    """Return whether this is a limit on positions whose velocity form is the library's own."""
    own = JointPositionLimit.velocity_bounds
    return isinstance(bound, JointPositionLimit) and type(bound).velocity_bounds is own

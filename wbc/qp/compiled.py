"""The compiled assembly: copies what tasks, contacts and limits ask for, and calls the kernels.

The same program as `wbc.qp.assembly` makes with numpy, which is its reference: the tests compare
the two. Tasks, contacts and limits of other classes than the library's own write their rows in
Python, as in the other assembly; the kernels do the rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from wbc.command import Command, CommandSource
from wbc.contacts import Contact
from wbc.kinematics import Kinematics
from wbc.limits import LimitSet
from wbc.qp.assembly import Assembly, Formulation
from wbc.qp.cost import Regularisation
from wbc.qp.elimination import StanceElimination
from wbc.qp.kernels.buffers import Buffers, Sizes
from wbc.qp.kernels.program import assemble, recover
from wbc.qp.parameter_update import (
    Update,
    UpdateAndWritten,
    bound_update,
    contact_update,
    dense_task_update,
    has_contact_kernel,
    has_motion_kernel,
    joint_task_update,
    limit_update,
    motion_task_update,
    torque_update,
)
from wbc.qp.priorities import rows_of
from wbc.qp.problem import Problem
from wbc.qp.row_errors import raise_row_error
from wbc.robot import Robot
from wbc.tasks import JointTask, MotionTask, Task
from wbc.tasks.motion import CENTROID


class CompiledAssembly:
    """Builds the QP of one structure in compiled code; see `Assembly` for the arguments.

    Attributes:
        written: the arrays of `memory` that each task, contact and limit writes.
        memory: all reals of the kernels.
    """

    def __init__(
        self,
        robot: Robot,
        tasks: Sequence[Task],
        contacts: Sequence[Contact],
        limits: LimitSet,
        regularisation: Regularisation,
    ) -> None:
        layout = Assembly(robot, tasks, contacts, limits, Formulation.REDUCED, regularisation)
        m = layout.elimination
        stance = isinstance(m, StanceElimination)
        self._contacts = list(layout.contacts)
        order = layout.order
        rigid = [c for c, _ in self._contacts[1 if stance else 0 :] if c.motion_weight is None]
        upper = [member for members in order.upper for member in members]
        last = [member for member in order.last if not isinstance(member, JointTask)]
        joint_tasks = [member for member in order.last if isinstance(member, JointTask)]
        stack = _Stack([*upper, *last], [*rigid, *order.exact])
        first = sum(map(rows_of, upper))
        dense_tasks = [t for t in tasks if t in stack.first]
        motion_tasks = [t for t in tasks if isinstance(t, MotionTask) and has_motion_kernel(t)]
        frames = _FrameTable(robot, motion_tasks, [c for c in contacts if has_contact_kernel(c)])
        joints = _joints_behind(robot, self._contacts[0][0].frame_id) if stance else []
        na, eliminated = robot.na, m.eliminated
        self._buffers = buffers = Buffers(
            Sizes(
                joints=na,
                forces=m.W.shape[0],
                unknowns=m.n,
                frames=len(frames.ids),
                motion_tasks=len(motion_tasks),
                joint_rows=sum(t.size for t in joint_tasks),
                contacts=len(contacts),
                cone_rows=sum(c.cone.shape[0] for c in contacts),
                dense_rows=stack.size,
                cost_rows=stack.cost,
                residual_rows=first - 3 * (-(stack.cost - first + eliminated) // 3),
                bounds=len(limits.bounds),
                limited_torques=0 if limits.torque is None else na,
                limit_rows=sum(limit.size for limit in limits.inequalities),
                stance_joints=len(joints),
                dense_columns=len(joints) + 1 if stance else m.n + 1,
                constraint_rows=layout.equality.size - na,
            )
        )
        tree, maps, program = buffers.tree, buffers.maps, buffers.program
        tree.parent[:] = [max(robot.model.parents[i] - 1, 0) for i in range(1, na + 2)]
        tree.gravity[:] = robot.model.gravity.linear
        used = [robot.model.frames[i] for i in frames.ids]
        buffers.frames.body[:] = [frame.parentJoint - 1 for frame in used]
        buffers.frames.in_body[:] = [frame.placement.homogeneous for frame in used]
        maps.stance_joints[:] = joints
        maps.dense_columns[:] = [*joints, m.n] if stance else range(m.n + 1)
        maps.W[:] = m.W
        program.regularisation[m.joints] = regularisation.acceleration
        program.regularisation[m.free] = regularisation.force * m.unit**2
        program.lb[:], program.ub[:] = -np.inf, np.inf
        updates = [
            *_task_updates(motion_tasks, joint_tasks, dense_tasks, buffers, stack, frames),
            *_contact_updates(self._contacts, buffers, stack, frames),
            *_limit_updates(limits, dict(self._contacts), buffers),
        ]
        self._updates: list[tuple[object, Update]] = [(owner, u) for owner, (u, _) in updates]
        self.written = {owner: arrays for owner, (_, arrays) in updates}
        self._problem = Problem(
            program.H,
            program.g,
            program.C,
            program.lb,
            program.ub,
            na,
            layout.equality,
            layout.blocks,
            levels=order.levels(program.G, layout.blocks, limits.inequalities),
        )
        root = float(np.sqrt(regularisation.force))
        self._arguments = (*buffers.arrays, first, robot.mass, float(m.unit), root)
        self.memory = buffers.arrays[0]
        self._nv, self._na, self._nf = robot.nv, na, m.W.shape[0]

    def build(self, kin: Kinematics) -> Problem:
        """Return the QP of the tick; its arrays are valid until the next call.

        Raises:
            TaskError: an attribute of a task has a wrong shape or type.
            ContactError: an attribute of a contact has.
            LimitError: an attribute of a limit has.
        """
        self.update(kin)
        return self.assemble(kin)

    def update(self, kin: Kinematics) -> None:
        """Copy what tasks, contacts and limits ask for."""
        owner: object = None
        try:
            for owner, update in self._updates:  # noqa: B007 - named when it fails
                update(kin)
        except (ValueError, TypeError, AttributeError) as error:
            raise_row_error(owner, error)

    def assemble(self, kin: Kinematics) -> Problem:
        """Return the QP of the references that `update` copied."""
        state = kin.state
        self._problem.finite = assemble(
            kin.mass_matrix,
            kin.bias_forces,
            kin.data.J.T,
            kin.joint_placements,
            state.q,
            state.v,
            *self._arguments,
        )
        return self._problem

    def recover(
        self,
        x: np.ndarray,
        kin: Kinematics,
        dt: float,
        source: CommandSource | None = None,
    ) -> Command | None:
        """Return the command of a solution; None when it is not finite."""
        nv, na = self._nv, self._na
        start = nv + 3 * na
        out = np.empty(start + self._nf)
        state = kin.state
        self._buffers.program.x[:] = x
        if not recover(state.q, state.v, *self._buffers.arrays, dt, out):
            return None
        wrenches = {}
        for contact, forces in self._contacts:
            wrenches[contact.name] = contact.wrench(out[start + forces.start : start + forces.stop])
        return Command(
            out[nv : nv + na],
            out[:nv],
            wrenches,
            out[nv + na : nv + 2 * na],
            out[nv + 2 * na : start],
            source=source,
        )


class _Stack:
    """Stacks the rows of dense tasks and contacts, those of the cost first.

    Args:
        cost: tasks and contacts whose rows are in the cost.
        exact: tasks and contacts whose rows become equalities.

    Attributes:
        first: first row of each.
        cost: rows of the cost.
        size: rows of all.
    """

    def __init__(self, cost: Sequence[Task | Contact], exact: Sequence[Task | Contact]) -> None:
        self.first: dict[object, int] = {}
        self.size = self.cost = 0
        for item in (*cost, *exact):
            self.first[item] = self.size
            self.size += item.size if isinstance(item, Task) else item.motion_size
            if len(self.first) <= len(cost):
                self.cost = self.size


class _FrameTable:
    """Lists the frames that tasks and contacts refer to, each once, after the centroid.

    A contact with a placement of its own has an entry of its own, at the end.

    Attributes:
        ids: their indices in the model; that of the base for the centroid.
    """

    def __init__(
        self, robot: Robot, tasks: Sequence[MotionTask], contacts: Sequence[Contact]
    ) -> None:
        self._placed = [c for c in contacts if c.placement is not None]
        shared = [c.frame_id for c in contacts if c.placement is None]
        used = dict.fromkeys([*(t.frame_id for t in tasks), *shared])
        used.pop(CENTROID, None)
        base = robot.model.getFrameId(robot.model.names[1], pin.FrameType.JOINT)
        self.ids = [base, *used, *(c.frame_id for c in self._placed)]

    def index(self, owner: MotionTask | Contact) -> int:
        """Return the entry of a task's or contact's frame."""
        if owner in self._placed:
            return len(self.ids) - len(self._placed) + self._placed.index(owner)
        return 0 if owner.frame_id == CENTROID else self.ids.index(owner.frame_id, 1)


_Updates = list[tuple[object, UpdateAndWritten]]


def _task_updates(
    motion_tasks: Sequence[MotionTask],
    joint_tasks: Sequence[JointTask],
    dense_tasks: Sequence[Task],
    buffers: Buffers,
    stack: _Stack,
    frames: _FrameTable,
) -> _Updates:
    updates: _Updates = []
    for k, task in enumerate(motion_tasks):
        row = stack.first[task]
        updates.append((task, motion_task_update(task, buffers, k, frames.index(task), row)))
    for dense in dense_tasks:
        if not has_motion_kernel(dense):
            updates.append((dense, dense_task_update(dense, buffers, stack.first[dense])))
    start = 0
    for joint_task in joint_tasks:
        part = slice(start, start + joint_task.size)
        updates.append((joint_task, joint_task_update(joint_task, buffers, part)))
        start = part.stop
    return updates


def _contact_updates(
    contacts: Sequence[tuple[Contact, slice]],
    buffers: Buffers,
    stack: _Stack,
    frames: _FrameTable,
) -> _Updates:
    updates: _Updates = []
    cone_row = 0
    for k, (contact, forces) in enumerate(contacts):
        frame = frames.index(contact) if has_contact_kernel(contact) else 0
        row = stack.first.get(contact, -1)
        update = contact_update(contact, buffers, k, frame, forces, cone_row, row)
        updates.append((contact, update))
        cone_row += contact.cone.shape[0]
    return updates


def _limit_updates(limits: LimitSet, forces: dict[Contact, slice], buffers: Buffers) -> _Updates:
    updates: _Updates = [(b, bound_update(b, buffers, k)) for k, b in enumerate(limits.bounds)]
    if limits.torque is not None:
        updates.append((limits.torque, torque_update(limits.torque, buffers)))
    start = 0
    for limit in limits.inequalities:
        part = slice(start, start + limit.size)
        updates.append((limit, limit_update(limit, buffers, part, forces)))
        start = part.stop
    return updates


def _joints_behind(robot: Robot, frame_id: int) -> list[int]:
    """Return the joints between the base and a frame, ascending, as indices into (na,) vectors."""
    joint = robot.model.frames[frame_id].parentJoint
    found = []
    while joint > 1:
        found.append(robot.model.joints[joint].idx_v - 6)
        joint = robot.model.parents[joint]
    return sorted(found)

"""The compiled assembly: gathers what tasks, contacts and limits want, and calls the kernels.

The same program as `wbc.qp.assembly` makes with numpy, which is its reference: the tests hold
one against the other. Tasks, contacts and limits of other classes than the library's own state
their rows in Python, as in the other assembly; the kernels do the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pinocchio as pin

from wbc.command import Command
from wbc.contacts import Contact
from wbc.kinematics import Kinematics
from wbc.limits import AccelerationBound, JointPositionLimit, JointVelocityLimit, TorqueLimit
from wbc.qp.assembly import Assembly, Formulation
from wbc.qp.cost import Regularisation
from wbc.qp.elimination import Stance
from wbc.qp.kernels import groups
from wbc.qp.kernels.program import assemble, recover
from wbc.qp.problem import Problem
from wbc.qp.writing import naming
from wbc.robot import Robot
from wbc.tasks import JointTask, MotionTask, PostureTask, Reference, Task

_ACCELERATIONS, _POSITIONS, _VELOCITIES = 0, 1, 2
_CONE_ROWS = 16

Gather = Callable[[Kinematics], None]


class CompiledAssembly:
    """Builds the QP of one structure in compiled code; see `Assembly` for the arguments."""

    def __init__(
        self,
        robot: Robot,
        tasks: Sequence[Task],
        contacts: Sequence[Contact],
        bounds: Sequence[AccelerationBound],
        torque_limit: TorqueLimit | None,
        regularisation: Regularisation,
    ) -> None:
        layout = Assembly(
            robot, tasks, contacts, bounds, torque_limit, Formulation.REDUCED, regularisation
        )
        self._gathers: list[tuple[object, Gather]] = []
        self._frames = _FrameTable(robot)
        self._contacts = [(contact, rows) for contact, rows in layout.contacts]
        n, nv, na = layout.n, robot.nv, robot.na
        nf = sum(c.motion_size for c, _ in self._contacts)
        stance = isinstance(layout.elimination, Stance)
        unit = layout.elimination.unit
        own = [t for t in tasks if _is_motion(t)]
        weighted = [t for t in tasks if t.priority == 1 and not isinstance(t, JointTask)]
        exact = [t for t in tasks if t.priority == 0]
        soft = [c for c, _ in self._contacts if c.motion_weight is not None]
        rigid = [c for c, _ in self._contacts[1 if stance else 0 :] if c.motion_weight is None]
        ordered: list[Task | Contact] = [*weighted, *soft, *rigid, *exact]
        first: dict[object, int] = {}
        count = cost_rows = 0
        for thing in ordered:
            first[thing] = count
            count += thing.size if isinstance(thing, Task) else thing.motion_size
            if thing in weighted or thing in soft:
                cost_rows = count
        self._rows = groups.Rows(np.zeros((count, nv)), np.zeros(count), np.ones(count))
        self._tasks = groups.Tasks(
            np.zeros((len(own), 4), dtype=np.int64),
            np.tile(np.eye(4), (len(own), 1, 1)),
            np.zeros((len(own), 12)),
            np.zeros((len(own), 12)),
        )
        for k, task in enumerate(t for t in own if isinstance(t, MotionTask)):
            self._add_motion(k, task, first[task])
        for thing in ordered:
            if isinstance(thing, Task) and thing not in own:
                self._add_written(thing, first[thing])
        self._wishes = self._add_wishes(tasks)
        self._contact_rows = groups.Contacts(
            np.zeros((len(self._contacts), 5), dtype=np.int64),
            np.zeros((len(self._contacts), 3)),
            np.zeros((len(self._contacts), _CONE_ROWS, 6)),
            np.zeros((nf, nv)),
            np.zeros(nf),
        )
        for k, (contact, rows) in enumerate(self._contacts):
            self._add_contact(k, contact, rows, first.get(contact, -1))
        self._limits = self._add_limits(bounds, torque_limit, na)
        joints = np.zeros(0, dtype=np.int64)
        dense = np.arange(n + 1)
        if stance:
            joints = _joints_behind(robot, self._contacts[0][0].frame_id)
            dense = np.append(joints, n)
        free = layout.elimination
        self._maps = groups.Maps(
            joints,
            dense,
            *(np.zeros((k, n + 1)) for k in (6, nf, na, 6)),
        )
        self._maps.W[:] = free.W
        gone = 6 if stance else 0
        small = np.zeros(n)
        small[:na] = regularisation.acceleration
        small[na:] = regularisation.force * unit**2
        size = layout.equality.size
        self._program = groups.Program(
            np.zeros((cost_rows + gone, n + 1)),
            np.zeros((n, n)),
            np.zeros(n),
            np.zeros((size - na, n)),
            np.full(size, -np.inf),
            np.full(size, np.inf),
            small,
        )
        program = self._program
        self._problem = Problem(
            program.H,
            program.g,
            program.C,
            program.lb,
            program.ub,
            na,
            layout.equality,
            layout.blocks,
        )
        self._tree = _tree(robot)
        self._arguments = (
            self._tree,
            self._frames.group(nv),
            self._tasks,
            self._wishes,
            self._contact_rows,
            self._rows,
            self._limits,
            self._maps,
            program,
            float(pin.computeTotalMass(robot.model)),
            float(unit),
            float(np.sqrt(regularisation.force)),
        )
        self._clip = self._limits.torque
        self._size = nv + 3 * na + nf
        self._nv, self._na = nv, na

    def build(self, kin: Kinematics) -> Problem:
        """The QP of the tick; its arrays are valid until the next call.

        Raises:
            TaskError: an attribute of a task has a wrong shape or type.
            ContactError: an attribute of a contact has.
        """
        for owner, gather in self._gathers:
            try:
                gather(kin)
            except (ValueError, TypeError, AttributeError) as error:
                naming(owner, error)
        model, data = kin.model, kin.data
        for place, frame_id in self._frames.places:
            place[:] = pin.updateFramePlacement(model, data, frame_id).homogeneous
        state = kin.state
        self._problem.finite = assemble(
            kin.mass_matrix, kin.bias_forces, data.J.T, state.q, state.v, *self._arguments
        )
        return self._problem

    def recover(self, x: np.ndarray, kin: Kinematics, dt: float) -> Command | None:
        """The command of a solution; None when it is not finite."""
        out = np.empty(self._size)
        state = kin.state
        if not recover(x, state.q, state.v, self._maps, self._clip, dt, out):
            return None
        nv, na = self._nv, self._na
        start = nv + 3 * na
        wrenches = {}
        for contact, rows in self._contacts:
            if contact.motion_size == 6:
                wrenches[contact.name] = out[start + rows.start : start + rows.stop]
            else:
                wrench = wrenches[contact.name] = np.zeros(6)
                wrench[:3] = out[start + rows.start : start + rows.stop]
        return Command(
            out[nv : nv + na],
            out[:nv],
            wrenches,
            out[nv + na : nv + 2 * na],
            out[nv + 2 * na : start],
        )

    def _add_motion(self, k: int, task: MotionTask, row: int) -> None:
        group, rows = self._tasks, task.components
        group.place[k] = (self._frames.index(task.frame_id), rows.start, task.size, row)
        reference = Reference(group.target[k], group.reference[k])
        kp, kd = group.gain[k, :6][rows], group.gain[k, 6:][rows]
        root = self._rows.root[row : row + task.size]
        gains: object = None

        def gather(kin: Kinematics) -> None:
            nonlocal gains
            task.refer(kin, reference)
            if gains is not task.gains:
                gains = task.gains
                kp[:], kd[:] = task.kp, task.kd
                root[:] = task.sqrt_weight

        self._gathers.append((task, gather))

    def _add_written(self, task: Task, row: int) -> None:
        rows = slice(row, row + task.size)
        A, b, root = self._rows.A[rows], self._rows.b[rows], self._rows.root[rows]

        def gather(kin: Kinematics) -> None:
            task.write(kin, A, b)
            root[:] = task.sqrt_weight

        self._gathers.append((task, gather))

    def _add_wishes(self, tasks: Sequence[Task]) -> groups.Wishes:
        joint_tasks = [t for t in tasks if t.priority == 1 and isinstance(t, JointTask)]
        count = sum(t.size for t in joint_tasks)
        index = [t.index for t in joint_tasks]
        wishes = groups.Wishes(
            np.concatenate(index).astype(np.int64) if index else np.zeros(0, dtype=np.int64),
            np.zeros(count),
            np.zeros((2, count)),
            np.zeros((3, count)),
        )
        start = 0
        for task in joint_tasks:
            rows = slice(start, start + task.size)
            self._add_wish(task, wishes, rows)
            start = rows.stop
        return wishes

    def _add_wish(self, task: JointTask, wishes: groups.Wishes, rows: slice) -> None:
        velocity, acceleration = wishes.reference[0, rows], wishes.reference[1, rows]
        kp, kd, weight = (gain[rows] for gain in wishes.gain)
        target = wishes.target[rows]
        gains: object = None

        def gather_posture(kin: Kinematics) -> None:
            nonlocal gains
            assert isinstance(task, PostureTask)
            target[:] = task.target
            velocity[:] = task.velocity
            acceleration[:] = task.acceleration
            if gains is not task.gains:
                gains = task.gains
                kp[:], kd[:], weight[:] = task.kp, task.kd, task.weight

        def gather(kin: Kinematics) -> None:
            task.write_joints(kin, acceleration)
            weight[:] = task.weight

        own = isinstance(task, PostureTask) and _inherits(task, PostureTask, "write_joints")
        self._gathers.append((task, gather_posture if own else gather))

    def _add_contact(self, k: int, contact: Contact, rows: slice, row: int) -> None:
        group = self._contact_rows
        own = _inherits(contact, Contact, "write")
        frame = self._frames.index(contact.frame_id) if own else 0
        group.place[k] = (frame, rows.start, contact.motion_size, row, contact.cone.shape[0])
        cone, number = group.cone[k], group.number[k]
        J, a = group.J[rows], group.a[rows]
        root = self._rows.root[row : row + contact.motion_size]
        soft = contact.motion_weight is not None
        seen: np.ndarray | None = None

        def gather(kin: Kinematics) -> None:
            nonlocal seen
            number[0], number[1] = contact.damping, contact.min_force
            number[2] = contact.max_force
            if contact.cone is not seen:
                seen = contact.cone
                cone[: seen.shape[0], : seen.shape[1]] = seen
            if soft:
                root[:] = (contact.motion_weight or 0.0) ** 0.5
            if not own:
                contact.write(kin, J, a)

        self._gathers.append((contact, gather))

    def _add_limits(
        self, bounds: Sequence[AccelerationBound], torque_limit: TorqueLimit | None, na: int
    ) -> groups.Limits:
        limits = groups.Limits(
            np.zeros(len(bounds), dtype=np.int64),
            np.ones((len(bounds), 2)),
            np.zeros((len(bounds), 3, na)),
            np.zeros(0 if torque_limit is None else na),
        )
        for k, bound in enumerate(bounds):
            limits.kind[k], gather = _limit_gather(bound, limits.number[k], limits.joint[k])
            self._gathers.append((bound, gather))
        if torque_limit is not None:

            def gather_torque(kin: Kinematics) -> None:
                limits.torque[:] = torque_limit.maximum

            self._gathers.append((torque_limit, gather_torque))
        return limits


class _FrameTable:
    """The frames that tasks and contacts refer to, each once; place 0 is the centroid's."""

    def __init__(self, robot: Robot) -> None:
        self._model = robot.model
        base = robot.model.getFrameId(robot.model.names[1], pin.FrameType.JOINT)
        self._ids = [base]
        self.places: list[tuple[np.ndarray, int]] = []

    def index(self, frame_id: int) -> int:
        """Place of a frame; a new one if need be."""
        if frame_id == 0:
            return 0
        if frame_id not in self._ids[1:]:
            self._ids.append(frame_id)
        return self._ids.index(frame_id, 1)

    def group(self, nv: int) -> groups.Frames:
        """The arrays; no frame can be added after that."""
        k = len(self._ids)
        body = [self._model.frames[i].parentJoint - 1 for i in self._ids]
        frames = groups.Frames(
            np.array(body, dtype=np.int64),
            np.zeros((k, 4, 4)),
            np.zeros((k, 6, nv)),
            np.zeros((k, 6)),
            np.zeros((k, 6)),
        )
        self.places = list(zip(frames.placement, self._ids, strict=True))
        return frames


def _limit_gather(
    bound: AccelerationBound, number: np.ndarray, joint: np.ndarray
) -> tuple[int, Gather]:
    """What kind of limit it is, and how its numbers are fetched."""
    lower, upper, braking = joint
    if isinstance(bound, JointPositionLimit) and _inherits(bound, JointPositionLimit, "bounds"):

        def gather_positions(kin: Kinematics) -> None:
            number[0], number[1] = bound.horizon, bound.recovery
            lower[:], upper[:], braking[:] = bound.lower, bound.upper, bound.braking

        return _POSITIONS, gather_positions
    if isinstance(bound, JointVelocityLimit) and _inherits(bound, JointVelocityLimit, "bounds"):

        def gather_velocities(kin: Kinematics) -> None:
            number[0] = bound.horizon
            np.negative(bound.maximum, out=lower)
            upper[:], braking[:] = bound.maximum, bound.braking

        return _VELOCITIES, gather_velocities

    def gather(kin: Kinematics) -> None:
        lower[:], upper[:] = bound.bounds(kin)

    return _ACCELERATIONS, gather


def _inherits(thing: object, owner: type, method: str) -> bool:
    """Whether a method is the library's own, which the kernels know."""
    return getattr(type(thing), method) is getattr(owner, method)


def _is_motion(task: Task) -> bool:
    return isinstance(task, MotionTask) and _inherits(task, MotionTask, "write")


def _joints_behind(robot: Robot, frame_id: int) -> np.ndarray:
    """Joints between the base and a frame, ascending, as indices into (na,) vectors."""
    joint = robot.model.frames[frame_id].parentJoint
    found = []
    while joint > 1:
        found.append(robot.model.joints[joint].idx_v - 6)
        joint = robot.model.parents[joint]
    return np.array(sorted(found), dtype=np.int64)


def _tree(robot: Robot) -> groups.Tree:
    model = robot.model
    count = model.njoints - 1
    parent = np.array([max(model.parents[i + 1] - 1, 0) for i in range(count)], dtype=np.int64)
    gravity = np.array(model.gravity.linear, dtype=float)
    return groups.Tree(parent, gravity, np.zeros((count, 6)), np.zeros((count, 6)))

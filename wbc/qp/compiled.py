"""The compiled assembly: gathers what tasks, contacts and limits want, and calls the kernels.

The same program as `wbc.qp.assembly` makes with numpy, which is its reference: the tests hold
one against the other. Tasks, contacts and limits of other classes than the library's own state
their rows in Python, as in the other assembly; the kernels do the rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from wbc.command import Command
from wbc.contacts import Contact
from wbc.kinematics import Kinematics
from wbc.limits import AccelerationBound, TorqueLimit
from wbc.qp.assembly import Assembly, Formulation
from wbc.qp.cost import Regularisation
from wbc.qp.elimination import Stance
from wbc.qp.kernels.groups import Frames, Tree
from wbc.qp.kernels.program import assemble, recover
from wbc.qp.kernels.store import Sizes, Store
from wbc.qp.parameter_update import (
    Gather,
    bound_gather,
    contact_gather,
    knows_contact,
    knows_motion,
    motion_gather,
    rows_gather,
    torque_gather,
    wish_gather,
)
from wbc.qp.problem import Problem
from wbc.qp.row_errors import raise_row_error
from wbc.robot import Robot
from wbc.tasks import JointTask, MotionTask, Task
from wbc.tasks.motion import CENTROID


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
        self._layout = layout
        m = layout.elimination
        stance = isinstance(m, Stance)
        self._contacts = list(layout.contacts)
        soft = [c for c, _ in self._contacts if c.motion_weight is not None]
        rigid = [c for c, _ in self._contacts[1 if stance else 0 :] if c.motion_weight is None]
        weighted = [t for t in tasks if t.priority == 1 and not isinstance(t, JointTask)]
        exact = [t for t in tasks if t.priority == 0]
        stack = _Stack([*weighted, *soft], [*rigid, *exact])
        motions = [t for t in tasks if isinstance(t, MotionTask) and knows_motion(t)]
        wishes = [t for t in tasks if t.priority == 1 and isinstance(t, JointTask)]
        frames = _FrameTable(robot, motions, [c for c in contacts if knows_contact(c)])
        joints = _joints_behind(robot, self._contacts[0][0].frame_id) if stance else []
        dense = [*joints, m.n] if stance else list(range(m.n + 1))
        na, eliminated = robot.na, m.eliminated
        self._store = store = Store(
            Sizes(
                na=na,
                nf=m.W.shape[0],
                n=m.n,
                k=len(frames.ids),
                t=len(motions),
                j=sum(t.size for t in wishes),
                c=len(contacts),
                r=stack.size,
                rg=-3 * (-(stack.cost + eliminated) // 3),
                l=len(bounds),
                nt=na if torque_limit is not None else 0,
                s=len(joints),
                d=len(dense),
                m=layout.equality.size - na,
            )
        )
        _fill_tree(store.tree, robot)
        frames.fill(store.frames)
        self._places = list(zip(store.frames.placement, frames.ids, strict=True))
        store.rows.cost[0] = stack.cost
        store.maps.stance[:], store.maps.dense[:] = joints, dense
        store.maps.W[:] = m.W
        program = store.program
        program.small[m.joints] = regularisation.acceleration
        program.small[m.free] = regularisation.force * m.unit**2
        program.lb[:], program.ub[:] = -np.inf, np.inf
        gathers: list[tuple[object, Gather]] = []
        for k, task in enumerate(motions):
            gather = motion_gather(task, store, k, frames.index(task), stack.first[task])
            gathers.append((task, gather))
        for written in (*weighted, *exact):
            if not knows_motion(written):
                gathers.append((written, rows_gather(written, store, stack.first[written])))
        start = 0
        for wish in wishes:
            rows = slice(start, start + wish.size)
            gathers.append((wish, wish_gather(wish, store, rows)))
            start = rows.stop
        for k, (contact, rows) in enumerate(self._contacts):
            frame = frames.index(contact) if knows_contact(contact) else 0
            row = stack.first.get(contact, -1)
            gathers.append((contact, contact_gather(contact, store, k, frame, rows, row)))
        gathers += [(bound, bound_gather(bound, store, k)) for k, bound in enumerate(bounds)]
        if torque_limit is not None:
            gathers.append((torque_limit, torque_gather(torque_limit, store)))
        self._gathers = gathers
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
        mass = float(pin.computeTotalMass(robot.model))
        root = float(np.sqrt(regularisation.force))
        self._arguments = (*store.arrays, mass, float(m.unit), root)
        self._nv, self._na, self._nf = robot.nv, na, m.W.shape[0]

    def build(self, kin: Kinematics) -> Problem:
        """The QP of the tick; its arrays are valid until the next call.

        Raises:
            TaskError: an attribute of a task has a wrong shape or type.
            ContactError: an attribute of a contact has.
        """
        self.gather(kin)
        return self.assemble(kin)

    def gather(self, kin: Kinematics) -> None:
        """Fetch what tasks, contacts and limits want now, and where their frames are."""
        owner: object = None
        try:
            for owner, gather in self._gathers:  # noqa: B007 - named when it fails
                gather(kin)
        except (ValueError, TypeError, AttributeError) as error:
            raise_row_error(owner, error)
        model, data = kin.model, kin.data
        for place, frame_id in self._places:
            place[:] = pin.updateFramePlacement(model, data, frame_id).homogeneous

    def assemble(self, kin: Kinematics) -> Problem:
        """The QP of what was gathered."""
        state = kin.state
        self._problem.finite = assemble(
            kin.mass_matrix, kin.bias_forces, kin.data.J.T, state.q, state.v, *self._arguments
        )
        return self._problem

    def recover(self, x: np.ndarray, kin: Kinematics, dt: float) -> Command | None:
        """The command of a solution; None when it is not finite."""
        nv, na = self._nv, self._na
        start = nv + 3 * na
        out = np.empty(start + self._nf)
        state = kin.state
        if not recover(x, state.q, state.v, *self._store.arrays, dt, out):
            return None
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


class _Stack:
    """The rows of dense tasks and contacts one below the other, the cost's first.

    Args:
        cost: what is in the cost.
        exact: what becomes equalities.

    Attributes:
        first: first row of each.
        cost: rows of the cost.
        size: rows of all.
    """

    def __init__(self, cost: Sequence[Task | Contact], exact: Sequence[Task | Contact]) -> None:
        self.first: dict[object, int] = {}
        self.size = self.cost = 0
        for thing in (*cost, *exact):
            self.first[thing] = self.size
            self.size += thing.size if isinstance(thing, Task) else thing.motion_size
            if len(self.first) <= len(cost):
                self.cost = self.size


class _FrameTable:
    """The frames that tasks and contacts refer to, each once; the first place is the centroid's.

    Attributes:
        ids: their indices in the model; that of the base for the centroid.
    """

    def __init__(
        self, robot: Robot, tasks: Sequence[MotionTask], contacts: Sequence[Contact]
    ) -> None:
        self._model = robot.model
        used = dict.fromkeys([*(t.frame_id for t in tasks), *(c.frame_id for c in contacts)])
        used.pop(CENTROID, None)
        base = robot.model.getFrameId(robot.model.names[1], pin.FrameType.JOINT)
        self.ids = [base, *used]

    def index(self, thing: MotionTask | Contact) -> int:
        """Place of the frame of a task or contact."""
        return 0 if thing.frame_id == CENTROID else self.ids.index(thing.frame_id, 1)

    def fill(self, frames: Frames) -> None:
        """Write what does not change."""
        frames.body[:] = [self._model.frames[i].parentJoint - 1 for i in self.ids]


def _joints_behind(robot: Robot, frame_id: int) -> list[int]:
    """Joints between the base and a frame, ascending, as indices into (na,) vectors."""
    joint = robot.model.frames[frame_id].parentJoint
    found = []
    while joint > 1:
        found.append(robot.model.joints[joint].idx_v - 6)
        joint = robot.model.parents[joint]
    return sorted(found)


def _fill_tree(tree: Tree, robot: Robot) -> None:
    model = robot.model
    tree.parent[:] = [max(model.parents[i] - 1, 0) for i in range(1, model.njoints)]
    tree.gravity[:] = model.gravity.linear

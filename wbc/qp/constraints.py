"""The QP's constraints: bounds on accelerations and named rows for everything else."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wbc.contacts import Contact
from wbc.kinematics import Kinematics
from wbc.limits import AccelerationBound, TorqueLimit
from wbc.qp.contact_rows import ContactRows
from wbc.qp.elimination import Elimination
from wbc.qp.writing import write_task
from wbc.robot import Robot
from wbc.rows import RowBlock
from wbc.tasks import Task

_AXES = ("x", "y", "z", "roll", "pitch", "yaw")
_BASE = ("fx", "fy", "fz", "mx", "my", "mz")


class Constraints:
    """Writes `lb ≤ [x[:bounded]; C x] ≤ ub`.

    All rows are kept as `low ≤ R x̂ ≤ high` with x̂ = (x, 1): the last column of R, the constant
    part, is brought to the other side in one go. The order of the rows: base dynamics (when
    they remain), motion of exact contacts, exact tasks, torques, cones, normal forces.

    Args:
        robot: the robot.
        exact_tasks: tasks that become equalities.
        contacts: the contacts; the eliminated one first.
        bounds: limits on joint accelerations.
        torque_limit: limit on torques, or None.
        m: the formulation.

    Attributes:
        blocks: names of all rows, simple bounds first.
        equality: (bounded + m,) which of them are equalities.
        bounded: number of simple bounds.
    """

    def __init__(
        self,
        robot: Robot,
        exact_tasks: Sequence[Task],
        contacts: ContactRows,
        bounds: Sequence[AccelerationBound],
        torque_limit: TorqueLimit | None,
        m: Elimination,
    ) -> None:
        self._m = m
        self._contact_rows = contacts
        self._bounds = list(bounds)
        self._torque_limit = torque_limit
        self.bounded = m.joints.stop
        forces = list(contacts)
        exact = [
            (c, rows)
            for c, rows in forces
            if c.motion_weight is None and rows.start >= m.eliminated
        ]
        blocks: list[RowBlock] = []

        def add(
            name: str, unit: str, size: int, labels: tuple[str, ...] = (), switch: int = 3
        ) -> slice:
            start = blocks[-1].stop if blocks else 0
            blocks.append(RowBlock(name, unit, start, start + size, labels, switch))
            return slice(start - self.bounded, start + size - self.bounded)

        if m.joints.start:
            add("base acceleration", "m/s², rad/s²", m.joints.start)
        limits = " or ".join(b.name for b in bounds) or "joint acceleration"
        add(limits, "rad/s²", robot.na, robot.joint_names)
        base = add("base dynamics", "N, N·m", 6, _BASE) if m.E.shape[0] else slice(0, 0)
        self._equalities = slice(base.stop, base.stop)
        motions, tasks = [], []
        for contact, source in exact:
            size = contact.motion_size
            rows = add(f"{contact.name} motion", "m/s², rad/s²", size, _AXES[:size])
            motions.append((source, rows))
            self._equalities = slice(base.stop, rows.stop)
        for task in exact_tasks:
            rows = add(task.name, task.unit, task.size, task.labels)
            tasks.append((task, rows))
            self._equalities = slice(base.stop, rows.stop)
        self._torques = slice(0, 0)
        if torque_limit is not None:
            self._torques = add(torque_limit.name, torque_limit.unit, robot.na, robot.joint_names)
        cones = [
            (c, rows, add(f"{c.name} cone", "N, N·m", c.cone.shape[0], c.cone_labels, 4))
            for c, rows in forces
        ]
        normals = [
            (c, rows.start + 2, add(f"{c.name} normal force", "N", 1, ("fz",)).start)
            for c, rows in forces
        ]

        total = blocks[-1].stop
        self.blocks = tuple(blocks)
        self.equality = np.zeros(total, dtype=bool)
        self.equality[self.bounded :][base] = True
        self.equality[self.bounded :][self._equalities] = True
        self._lb, self._ub = np.full(total, -np.inf), np.full(total, np.inf)
        self._joint_lb = self._lb[m.joints]
        self._joint_ub = self._ub[m.joints]
        self._row_lb, self._row_ub = self._lb[self.bounded :], self._ub[self.bounded :]
        rows_total = total - self.bounded
        self._R = np.zeros((rows_total, m.n + 1))
        self._low, self._high = np.full(rows_total, -np.inf), np.full(rows_total, np.inf)
        self._low[base] = self._high[base] = 0.0
        self._C = np.zeros((rows_total, m.n))
        self._base = base
        # Rows in the acceleration, stacked for one projection.
        first, size = base.stop, self._equalities.stop - base.stop
        self._A, self._b = np.zeros((size, robot.nv)), np.zeros(size)
        self._motions = [
            (source, self._A[_shift(rows, first)], self._b[_shift(rows, first)])
            for source, rows in motions
        ]
        self._tasks = [
            (task, self._A[_shift(rows, first)], self._b[_shift(rows, first)])
            for task, rows in tasks
        ]
        # A cone of unknowns is constant; that of an eliminated wrench is not.
        self._cones: list[tuple[Contact, slice, slice, np.ndarray | None]] = [
            (c, source, rows, None) for c, source, rows in cones
        ]
        for _, _, rows in cones:
            self._high[rows] = 0.0
        self._normals = normals
        for _, source_row, row in normals:
            self._R[row] = m.W[source_row]

    def build(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """C (m, n), lb and ub (bounded + m,), valid until the next call."""
        m, R, low, high = self._m, self._R, self._low, self._high
        self._bound_joints(kin)
        if m.E.shape[0]:
            R[self._base] = m.E
        if self._A.shape[0]:
            for source, A, b in self._motions:
                A[:] = self._contact_rows.J[source]
                b[:] = self._contact_rows.a[source]
            for task, A, b in self._tasks:
                write_task(task, kin, A, b)
            m.project(self._A, R[self._equalities])
            low[self._equalities] = high[self._equalities] = self._b
        if self._torque_limit is not None:
            R[self._torques] = m.T
            high[self._torques] = self._torque_limit.maximum
            np.negative(self._torque_limit.maximum, out=low[self._torques])
        for k, (contact, source, rows, written) in enumerate(self._cones):
            cone = contact.cone
            if source.start < m.eliminated or cone is not written:
                np.matmul(cone, m.W[source], out=R[rows])
                self._cones[k] = (contact, source, rows, cone)
        for contact, source_row, row in self._normals:
            if source_row < m.eliminated:
                R[row] = m.W[source_row]
            low[row], high[row] = contact.min_force, contact.max_force
        shift = R[:, -1]
        np.subtract(low, shift, out=self._row_lb)
        np.subtract(high, shift, out=self._row_ub)
        self._C[:] = R[:, :-1]
        return self._C, self._lb, self._ub

    def _bound_joints(self, kin: Kinematics) -> None:
        lb, ub = self._joint_lb, self._joint_ub
        lb.fill(-np.inf)
        ub.fill(np.inf)
        for bound in self._bounds:
            low, high = bound.bounds(kin)
            np.maximum(lb, low, out=lb)
            np.minimum(ub, high, out=ub)
        # Two limits that exclude each other (beyond a stop at full speed): the middle.
        crossed = lb > ub
        if crossed.any():
            lb[crossed] = ub[crossed] = 0.5 * (lb + ub)[crossed]


def _shift(rows: slice, by: int) -> slice:
    return slice(rows.start - by, rows.stop - by)

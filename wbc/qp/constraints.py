"""The QP's constraints: bounds on accelerations and named rows for everything else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wbc.kinematics import Kinematics
from wbc.limits import AccelerationBound, LimitSet
from wbc.qp.contact_rows import ContactRows
from wbc.qp.elimination import Elimination
from wbc.qp.row_errors import write_bounds
from wbc.qp.row_groups import (
    BaseDynamicsRows,
    ExactRows,
    ForceRows,
    InequalityRows,
    RowGroup,
    TorqueRows,
)
from wbc.qp.rows import RowBlock
from wbc.robot import Robot
from wbc.tasks import Task


class Constraints:
    """Writes `lb ≤ [x[:bounded]; C x] ≤ ub`.

    All rows are written as `low ≤ R x̂ ≤ high` with x̂ = (x, 1): the last column of R, the constant
    part, is brought to the other side in one go. The order of the rows: base dynamics (when
    they remain), motion of exact contacts, exact tasks, torques, general limits, forces contact by
    contact.

    Args:
        robot: the robot.
        exact_tasks: tasks that become equalities.
        contacts: the contacts; the eliminated one first.
        limits: limits, by kind.
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
        limits: LimitSet,
        m: Elimination,
    ) -> None:
        self._bounds = limits.bounds
        self.bounded = m.joints.stop
        groups: list[RowGroup] = []
        if m.E.shape[0]:
            groups.append(BaseDynamicsRows(m))
        exact = ExactRows(m, contacts, exact_tasks)
        if exact.blocks:
            groups.append(exact)
        if limits.torque is not None:
            groups.append(TorqueRows(m, limits.torque, robot.joint_names))
        groups += [InequalityRows(m, limit, contacts) for limit in limits.inequalities]
        groups += [ForceRows(m, contact, source) for contact, source in contacts]
        self._groups = groups
        size = sum(group.size for group in groups)
        self._R, self._C = np.zeros((size, m.n + 1)), np.zeros((size, m.n))
        self._low, self._high = np.full(size, -np.inf), np.full(size, np.inf)
        self.equality = np.zeros(self.bounded + size, dtype=bool)
        blocks = _bound_blocks(robot, limits.bounds, m)
        start = 0
        for group in groups:
            rows = slice(start, start + group.size)
            group.place(self._R[rows], self._low[rows], self._high[rows])
            self.equality[self.bounded :][rows] = group.equality
            shift = self.bounded + start
            blocks += [replace(b, start=b.start + shift, stop=b.stop + shift) for b in group.blocks]
            start = rows.stop
        self.blocks = tuple(blocks)
        self._lb = np.full(self.bounded + size, -np.inf)
        self._ub = np.full(self.bounded + size, np.inf)
        self._lower, self._upper = np.zeros(robot.na), np.zeros(robot.na)
        self._joint_lb, self._joint_ub = self._lb[m.joints], self._ub[m.joints]
        self._row_lb, self._row_ub = self._lb[self.bounded :], self._ub[self.bounded :]

    def build(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return C (m, n), lb and ub (bounded + m,), valid until the next call."""
        self._bound_joints(kin)
        for group in self._groups:
            group.write(kin)
        constant = self._R[:, -1]
        np.subtract(self._low, constant, out=self._row_lb)
        np.subtract(self._high, constant, out=self._row_ub)
        self._C[:] = self._R[:, :-1]
        return self._C, self._lb, self._ub

    def _bound_joints(self, kin: Kinematics) -> None:
        if not self._bounds:
            return
        lb, ub = self._joint_lb, self._joint_ub
        lb.fill(-np.inf)
        ub.fill(np.inf)
        for bound in self._bounds:
            write_bounds(bound, kin, self._lower, self._upper)
            # Where limits exclude each other, the first holds.
            np.clip(self._lower, lb, ub, out=self._lower)
            np.clip(self._upper, lb, ub, out=self._upper)
            lb[:], ub[:] = self._lower, self._upper


def _bound_blocks(
    robot: Robot, bounds: Sequence[AccelerationBound], m: Elimination
) -> list[RowBlock]:
    """Name the simple bounds: on the base's acceleration, when it is in x, and on q̈."""
    first, stop = m.joints.start, m.joints.stop
    name = " or ".join(bound.name for bound in bounds) or "joint acceleration"
    blocks = [RowBlock(name, "rad/s²", first, stop, robot.joint_names)]
    if first:
        blocks.insert(0, RowBlock("base acceleration", "m/s², rad/s²", 0, first))
    return blocks

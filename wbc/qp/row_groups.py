"""Groups of constraint rows, one class per kind of constraint.

Each group owns consecutive rows `low ≤ R x̂ ≤ high`, x̂ = (x, 1): it is given views of its rows
once and rewrites in every tick what has changed.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from wbc.contacts import Contact
from wbc.kinematics import Kinematics
from wbc.limits import Limit, LimitRows, TorqueLimit
from wbc.qp.contact_rows import ContactRows
from wbc.qp.elimination import Elimination
from wbc.qp.row_errors import write_rows
from wbc.qp.rows import RowBlock
from wbc.tasks import Task

_AXES = ("x", "y", "z", "roll", "pitch", "yaw")


class RowGroup(ABC):
    """Consecutive constraint rows of one kind.

    Attributes:
        blocks: names of its rows, counted from its first row.
        equality: whether its rows are equalities.
    """

    blocks: tuple[RowBlock, ...]
    equality = False

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.blocks[-1].stop

    def place(self, R: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
        """Take views of its rows: R (size, n + 1) of zeros, low and high of ∓ infinity."""
        self.R, self.low, self.high = R, low, high

    @abstractmethod
    def write(self, kin: Kinematics) -> None:
        """Rewrite what has changed since the last tick."""


class BaseDynamicsRows(RowGroup):
    """`E x̂ = 0`, for a formulation that leaves the base's dynamics as equalities."""

    equality = True

    def __init__(self, m: Elimination) -> None:
        self._m = m
        labels = ("fx", "fy", "fz", "mx", "my", "mz")
        self.blocks = (RowBlock("base dynamics", "N, N·m", 0, 6, labels),)

    def write(self, kin: Kinematics) -> None:
        """See `RowGroup`."""
        self.R[:] = self._m.E
        self.low[:] = self.high[:] = 0.0


class ExactRows(RowGroup):
    """Exact contacts and exact tasks, `A v̇ = b`, stacked and projected together."""

    equality = True

    def __init__(self, m: Elimination, contacts: ContactRows, tasks: Sequence[Task]) -> None:
        self._m = m
        self._contacts = contacts
        exact = [
            (contact, source)
            for contact, source in contacts
            if contact.motion_weight is None and source.start >= m.eliminated
        ]
        size = sum(c.motion_size for c, _ in exact) + sum(t.size for t in tasks)
        self._A, self._b = np.zeros((size, contacts.J.shape[1])), np.zeros(size)
        self._motions, self._tasks = [], []
        blocks: list[RowBlock] = []

        def add(name: str, unit: str, count: int, labels: tuple[str, ...]) -> slice:
            start = blocks[-1].stop if blocks else 0
            blocks.append(RowBlock(name, unit, start, start + count, labels))
            return slice(start, start + count)

        for contact, source in exact:
            labels = _AXES[: contact.motion_size]
            rows = add(f"{contact.name} motion", "m/s², rad/s²", contact.motion_size, labels)
            self._motions.append((source, self._A[rows], self._b[rows]))
        for task in tasks:
            rows = add(task.name, task.unit, task.size, task.labels)
            self._tasks.append((task, self._A[rows], self._b[rows]))
        self.blocks = tuple(blocks)

    def write(self, kin: Kinematics) -> None:
        """See `RowGroup`."""
        for source, A, b in self._motions:
            A[:] = self._contacts.J[source]
            b[:] = self._contacts.a[source]
        for task, A, b in self._tasks:
            write_rows(task, kin, A, b)
        self._m.project(self._A, self.R)
        self.low[:] = self.high[:] = self._b


class TorqueRows(RowGroup):
    """`−τ_max ≤ T x̂ ≤ τ_max`."""

    def __init__(self, m: Elimination, limit: TorqueLimit, joints: tuple[str, ...]) -> None:
        self._m = m
        self._limit = limit
        self.blocks = (RowBlock(limit.name, limit.unit, 0, len(joints), joints),)

    def write(self, kin: Kinematics) -> None:
        """See `RowGroup`."""
        self.R[:] = self._m.T
        self.high[:] = self._limit.maximum
        np.negative(self._limit.maximum, out=self.low)


class InequalityRows(RowGroup):
    """A general limit, `lower ≤ A v̇ + F f ≤ upper`."""

    def __init__(self, m: Elimination, limit: Limit, contacts: ContactRows) -> None:
        self._m = m
        self._limit = limit
        nf, nv = contacts.J.shape
        self._F = F = np.zeros((limit.size, nf))
        columns = {contact: F[:, source] for contact, source in contacts}
        lower, upper = np.zeros(limit.size), np.zeros(limit.size)
        self._rows = LimitRows(np.zeros((limit.size, nv)), lower, upper, columns)
        self.blocks = (RowBlock(limit.name, limit.unit, 0, limit.size, limit.labels),)

    def write(self, kin: Kinematics) -> None:
        """See `RowGroup`."""
        rows = self._rows
        rows.clear()
        write_rows(self._limit, kin, rows)
        self._m.project(rows.A, self.R)
        self.R += self._F @ self._m.W
        self.low[:], self.high[:] = rows.lower, rows.upper


class ForceRows(RowGroup):
    """A contact's cone, `cone W x̂ ≤ 0`, and normal force, `min ≤ W_z x̂ ≤ max`.

    The rows of a force that is an unknown of its own are constant.
    """

    def __init__(self, m: Elimination, contact: Contact, source: slice) -> None:
        self._contact = contact
        self._W = m.W[source]
        self._changes = source.start < m.eliminated
        self._cone: np.ndarray | None = None
        k = contact.cone.shape[0]
        self.blocks = (
            RowBlock(f"{contact.name} cone", "N, N·m", 0, k, contact.cone_labels, switch=4),
            RowBlock(f"{contact.name} normal force", "N", k, k + 1, ("fz",)),
        )

    def place(self, R: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
        """See `RowGroup`."""
        super().place(R, low, high)
        self.high[:-1] = 0.0
        self.R[-1] = self._W[2]

    def write(self, kin: Kinematics) -> None:
        """See `RowGroup`."""
        contact = self._contact
        cone = contact.cone
        if self._changes or cone is not self._cone:
            self._cone = cone
            np.matmul(cone, self._W, out=self.R[:-1])
            self.R[-1] = self._W[2]
        self.low[-1], self.high[-1] = contact.min_force, contact.max_force

"""From tasks, contacts and limits to one quadratic program, and back from its solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wbc.contacts import Contact, SurfaceContact
from wbc.kinematics import Kinematics
from wbc.limits import AccelerationBound, TorqueLimit
from wbc.qp import elimination
from wbc.qp.elimination import Elimination
from wbc.qp.problem import Problem
from wbc.robot import Robot
from wbc.rows import RowBlock
from wbc.tasks import Task


class Formulation(Enum):
    """Which unknowns the QP has."""

    REDUCED = "reduced"  #: base and stance wrench eliminated; the fast one
    FULL = "full"  #: v̇ and f with the base dynamics as equalities; the readable one


@dataclass(frozen=True, slots=True)
class Regularisation:
    """Small costs that make the optimum unique.

    Attributes:
        force: on every contact force and moment, 1/N² and 1/(N·m)².
        acceleration: on every joint acceleration, s⁴/rad².
    """

    force: float = 1e-6
    acceleration: float = 1e-6


class Assembly:
    """Builds the QP of one structure: fixed lists of tasks, contacts and limits.

    Targets, weights and bounds may change from tick to tick; a change of the lists
    themselves needs another `Assembly`.
    """

    def __init__(
        self,
        robot: Robot,
        tasks: Sequence[Task],
        contacts: Sequence[Contact],
        bounds: Sequence[AccelerationBound],
        torque_limit: TorqueLimit | None,
        formulation: Formulation,
        regularisation: Regularisation,
    ) -> None:
        self._robot = robot
        self._exact_tasks = [t for t in tasks if t.priority == 0]
        self._tasks = [t for t in tasks if t.priority == 1]
        self._bounds = list(bounds)
        self._torque_limit = torque_limit
        self._formulation = formulation
        self._regularisation = regularisation
        # The contact that is eliminated comes first; commands name contacts, so order is free.
        first = _stance_contact(contacts) if formulation is Formulation.REDUCED else None
        self._stance = first
        self._contacts = [c for c in contacts if c is first] + [
            c for c in contacts if c is not first
        ]
        self._force_slices = _slices(c.motion_size for c in self._contacts)
        self._task_slices = _slices(t.size for t in self._tasks)
        nf = sum(c.motion_size for c in self._contacts)
        cost_rows = sum(t.size for t in self._tasks)
        self._A = np.zeros((cost_rows, robot.nv))
        self._b = np.zeros(cost_rows)
        self._cones = [c.cone for c in self._contacts]
        self._J = np.zeros((nf, robot.nv))
        self._a = np.zeros(nf)
        self._acceleration_start = 6 if formulation is Formulation.FULL else 0
        self.blocks = tuple(self._name_rows())
        total = self.blocks[-1].stop
        self._lb = np.full(total, -np.inf)
        self._ub = np.full(total, np.inf)
        self._equality = np.zeros(total, dtype=bool)
        for block in self.blocks:
            if block.name in self._equality_names:
                self._equality[block.start : block.stop] = True
        self._map: Elimination | None = None

    @property
    def _bounded(self) -> int:
        return self._acceleration_start + self._robot.na

    def _name_rows(self) -> list[RowBlock]:
        robot = self._robot
        blocks: list[RowBlock] = []
        start = 0

        def add(name: str, unit: str, size: int, labels: tuple[str, ...] = ()) -> None:
            nonlocal start
            blocks.append(RowBlock(name, unit, start, start + size, labels))
            start += size

        if self._acceleration_start:
            add("base acceleration", "m/s², rad/s²", self._acceleration_start)
        names = ", ".join(b.name for b in self._bounds) or "joint acceleration"
        add(names, "rad/s²", robot.na, robot.joint_names)
        self._equality_names: set[str] = set()

        def add_equality(name: str, unit: str, size: int, labels: tuple[str, ...] = ()) -> None:
            self._equality_names.add(name)
            add(name, unit, size, labels)

        if self._formulation is Formulation.FULL:
            add_equality("base dynamics", "N, N·m", 6, ("fx", "fy", "fz", "mx", "my", "mz"))
        for contact in self._contacts:
            if contact.motion_weight is None and contact is not self._stance:
                labels = ("x", "y", "z", "roll", "pitch", "yaw")[: contact.motion_size]
                add_equality(f"{contact.name} motion", "m/s², rad/s²", len(labels), labels)
        for task in self._exact_tasks:
            add_equality(task.name, task.unit, task.size, task.labels)
        if self._torque_limit is not None:
            add(self._torque_limit.name, self._torque_limit.unit, robot.na, robot.joint_names)
        for contact, cone in zip(self._contacts, self._cones, strict=True):
            add(f"{contact.name} cone", "N, N·m", cone.shape[0], contact.cone_labels)
        for contact in self._contacts:
            add(f"{contact.name} normal force", "N", 1, ("fz",))
        return blocks

    def build(self, kin: Kinematics) -> Problem:
        """The QP of the tick; its arrays are valid until the next call."""
        for contact, rows in zip(self._contacts, self._force_slices, strict=True):
            self._J[rows], self._a[rows] = contact.motion(kin)
        M, h, J = kin.mass_matrix, kin.bias_forces, self._J
        if self._formulation is Formulation.FULL:
            m = elimination.full(M, h, J)
        elif self._stance is not None:
            m = elimination.stance(M, h, J, self._a[:6])
        else:
            m = elimination.floating(M, h, J)
        self._map = m
        H, g = self._cost(kin, m)
        C = self._constraints(kin, m)
        return Problem(H, g, C, self._lb, self._ub, self._bounded, self._equality, self.blocks)

    def _cost(self, kin: Kinematics, m: Elimination) -> tuple[np.ndarray, np.ndarray]:
        A, b = self._A, self._b
        for task, rows in zip(self._tasks, self._task_slices, strict=True):
            task.write(kin, A[rows], b[rows])
            b[rows] -= A[rows] @ m.v0
            A[rows] *= task.sqrt_weight[:, None]
            b[rows] *= task.sqrt_weight
        parts, rests = [A @ m.V], [b]
        for contact, rows in zip(self._contacts, self._force_slices, strict=True):
            if contact.motion_weight is not None:
                root = np.sqrt(contact.motion_weight)
                parts.append(root * (self._J[rows] @ m.V))
                rests.append(root * (self._a[rows] - self._J[rows] @ m.v0))
        root = np.sqrt(self._regularisation.force)
        parts.append(root * m.W)
        rests.append(-root * m.w0)
        rows_x, rest = np.vstack(parts), np.concatenate(rests)
        H = rows_x.T @ rows_x
        i = self._acceleration_start
        H.flat[i * (H.shape[0] + 1) : self._bounded * H.shape[0] : H.shape[0] + 1] += (
            self._regularisation.acceleration
        )
        return H, -(rest @ rows_x)

    def _constraints(self, kin: Kinematics, m: Elimination) -> np.ndarray:
        lb, ub = self._lb, self._ub
        i, stop = self._acceleration_start, self._bounded
        lb[i:stop], ub[i:stop] = -np.inf, np.inf
        for bound in self._bounds:
            low, high = bound.bounds(kin)
            np.maximum(lb[i:stop], low, out=lb[i:stop])
            np.minimum(ub[i:stop], high, out=ub[i:stop])
        # Two limits that exclude each other (beyond a stop at full speed): the middle.
        crossed = lb[i:stop] > ub[i:stop]
        if crossed.any():
            middle = 0.5 * (lb[i:stop] + ub[i:stop])[crossed]
            lb[i:stop][crossed] = ub[i:stop][crossed] = middle
        parts = [m.E]
        row = stop
        row = _set(lb, ub, row, m.e, m.e)
        for contact, rows in zip(self._contacts, self._force_slices, strict=True):
            if contact.motion_weight is None and contact is not self._stance:
                parts.append(self._J[rows] @ m.V)
                rest = self._a[rows] - self._J[rows] @ m.v0
                row = _set(lb, ub, row, rest, rest)
        for task in self._exact_tasks:
            A, b = np.empty((task.size, self._robot.nv)), np.empty(task.size)
            task.write(kin, A, b)
            parts.append(A @ m.V)
            b -= A @ m.v0
            row = _set(lb, ub, row, b, b)
        if self._torque_limit is not None:
            limit = self._torque_limit.maximum
            parts.append(m.T)
            row = _set(lb, ub, row, -limit - m.t0, limit - m.t0)
        for cone, rows in zip(self._cones, self._force_slices, strict=True):
            parts.append(cone @ m.W[rows])
            ub[row : row + cone.shape[0]] = -(cone @ m.w0[rows])
            row += cone.shape[0]
        for contact, rows in zip(self._contacts, self._force_slices, strict=True):
            z = rows.start + 2
            parts.append(m.W[z : z + 1])
            lb[row], ub[row] = contact.min_force - m.w0[z], contact.max_force - m.w0[z]
            row += 1
        return np.vstack(parts)

    def recover(
        self, x: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        """Acceleration (nv,), torques (na,) and contact wrenches (6,) by name."""
        assert self._map is not None, "build comes before recover"
        m = self._map
        f = m.W @ x + m.w0
        wrenches = {}
        for contact, rows in zip(self._contacts, self._force_slices, strict=True):
            wrench = np.zeros(6)
            wrench[: contact.motion_size] = f[rows]
            wrenches[contact.name] = wrench
        return m.V @ x + m.v0, m.T @ x + m.t0, wrenches


def _stance_contact(contacts: Sequence[Contact]) -> Contact | None:
    for contact in contacts:
        if isinstance(contact, SurfaceContact) and contact.motion_weight is None:
            return contact
    return None


def _slices(sizes: object) -> list[slice]:
    out, start = [], 0
    for size in sizes:  # type: ignore[attr-defined]
        out.append(slice(start, start + size))
        start += size
    return out


def _set(lb: np.ndarray, ub: np.ndarray, row: int, low: np.ndarray, high: np.ndarray) -> int:
    lb[row : row + low.size] = low
    ub[row : row + high.size] = high
    return row + int(low.size)

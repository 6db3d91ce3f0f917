"""From tasks, contacts and limits to one quadratic program, and back from its solution."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

import numpy as np

from wbc.contacts import Contact, SurfaceContact
from wbc.kinematics import Kinematics
from wbc.limits import AccelerationBound, TorqueLimit
from wbc.qp.constraints import Constraints
from wbc.qp.contact_rows import ContactRows
from wbc.qp.cost import Cost, Regularisation
from wbc.qp.elimination import Elimination, Floating, Full, Stance
from wbc.qp.problem import Problem
from wbc.robot import Robot
from wbc.tasks import Task


class Formulation(Enum):
    """Which unknowns the QP has."""

    REDUCED = "reduced"  #: base and stance wrench eliminated; the fast one
    FULL = "full"  #: v̇ and f with the base dynamics as equalities; the readable one


class Assembly:
    """Builds the QP of one structure: fixed lists of tasks, contacts and limits.

    Targets, weights, gains and bounds may change from tick to tick; a change of the lists
    themselves, of a priority, or between exact and soft contact needs another `Assembly`.

    Args:
        robot: the robot.
        tasks: weighted and exact ones.
        contacts: of distinct names.
        bounds: limits on joint accelerations.
        torque_limit: limit on torques, or None.
        formulation: which unknowns.
        regularisation: small costs.
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
        stance = _stance_contact(contacts)
        # The contact that is eliminated comes first; commands name contacts, so order is free.
        ordered = [c for c in contacts if c is stance] + [c for c in contacts if c is not stance]
        self._contacts = rows = ContactRows(ordered, robot.nv)
        nf = rows.a.size
        unit = robot.mass * 9.81
        self._m: Elimination
        if formulation is Formulation.FULL:
            self._m = Full(robot.nv, nf, unit)
        elif stance is not None:
            self._m = Stance(robot.nv, nf, unit)
        else:
            self._m = Floating(robot.nv, nf, unit)
        self._x1 = np.ones(self._m.n + 1)
        weighted = [t for t in tasks if t.priority == 1]
        exact = [t for t in tasks if t.priority == 0]
        self._cost = Cost(weighted, rows, self._m, regularisation)
        self._constraints = Constraints(robot, exact, rows, bounds, torque_limit, self._m)

    def build(self, kin: Kinematics) -> Problem:
        """The QP of the tick; its arrays are valid until the next call.

        Raises:
            TaskError: an attribute of a task has a wrong shape or type.
            ContactError: an attribute of a contact has.
        """
        rows, constraints = self._contacts, self._constraints
        rows.write(kin)
        self._m.update(kin.mass_matrix, kin.bias_forces, rows.J, rows.a)
        H, g = self._cost.build(kin)
        C, lb, ub = constraints.build(kin)
        return Problem(
            H, g, C, lb, ub, constraints.bounded, constraints.equality, constraints.blocks
        )

    def recover(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        """Acceleration (nv,), torques (na,) and contact wrenches (6,) by name."""
        m, x1 = self._m, self._x1
        x1[:-1] = x
        f = m.W @ x1
        wrenches = {}
        for contact, rows in self._contacts:
            wrench = np.zeros(6)
            wrench[: contact.motion_size] = f[rows]
            wrenches[contact.name] = wrench
        return m.acceleration(x1), m.T @ x1, wrenches


def _stance_contact(contacts: Sequence[Contact]) -> Contact | None:
    """The first surface contact that moves exactly as told."""
    for contact in contacts:
        if isinstance(contact, SurfaceContact) and contact.motion_weight is None:
            return contact
    return None

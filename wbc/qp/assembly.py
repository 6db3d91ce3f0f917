"""From tasks, contacts and limits to one quadratic program, and back from its solution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import Enum

import numpy as np

from wbc.command import Command, CommandSource
from wbc.contacts import Contact
from wbc.kinematics import Kinematics
from wbc.limits import LimitSet
from wbc.qp.constraints import Constraints
from wbc.qp.contact_rows import ContactRows
from wbc.qp.cost import Cost, Regularisation, ResidualRows
from wbc.qp.elimination import (
    BaseElimination,
    Elimination,
    NoElimination,
    StanceElimination,
)
from wbc.qp.priorities import PriorityOrder, rows_of
from wbc.qp.problem import Problem
from wbc.robot import Robot
from wbc.tasks import Task


class Formulation(Enum):
    """Which unknowns the QP has and how it is assembled; the optimum is the same."""

    COMPILED = "compiled"  #: base and stance wrench eliminated, in compiled kernels; the fastest
    REDUCED = "reduced"  #: the same in numpy, for machines without Numba
    FULL = "full"  #: v̇ and f with the base dynamics as equalities; the simplest


class Assembly:
    """Builds the QP of one structure in numpy: fixed lists of tasks, contacts and limits.

    Targets, weights, gains and bounds may change from tick to tick; a change of the lists
    themselves, of a priority, or between exact and soft contact needs another `Assembly`.

    Args:
        robot: the robot.
        tasks: exact and weighted ones, of any levels.
        contacts: contacts with distinct names.
        limits: limits, by kind.
        formulation: reduced or full.
        regularisation: small costs.

    Attributes:
        contacts: the contacts, the eliminated one first, with their rows.
        elimination: the formulation's maps.
        n: number of unknowns.
        regularisation: as given.
        order: which task is of which level.
        blocks, equality: see `Problem`.
    """

    def __init__(
        self,
        robot: Robot,
        tasks: Sequence[Task],
        contacts: Sequence[Contact],
        limits: LimitSet,
        formulation: Formulation,
        regularisation: Regularisation,
    ) -> None:
        stance = _stance_contact(contacts)
        # The contact that is eliminated comes first; commands name contacts, so order is free.
        ordered = [c for c in contacts if c is stance] + [c for c in contacts if c is not stance]
        self.contacts = rows = ContactRows(ordered, robot.nv)
        nf = rows.a.size
        unit = robot.weight
        m: Elimination
        if formulation is Formulation.FULL:
            m = NoElimination(robot.nv, nf, unit)
        elif stance is not None:
            m = StanceElimination(robot.nv, nf, unit)
        else:
            m = BaseElimination(robot.nv, nf, unit)
        self.elimination, self.n = m, m.n
        self.regularisation = regularisation
        self._x1 = np.ones(m.n + 1)
        self._torque_limit = limits.torque
        self.order = order = PriorityOrder.sort(tasks, contacts, limits)
        upper = [member for members in order.upper for member in members]
        self._G = np.zeros((sum(map(rows_of, upper)), m.n + 1))
        self._upper = ResidualRows(upper, rows, m, self._G)
        self._cost = Cost(order.last, rows, m, regularisation)
        self._constraints = Constraints(robot, order.exact, rows, limits, m)
        self.blocks, self.equality = self._constraints.blocks, self._constraints.equality
        self._levels = order.levels(self._G, self.blocks, limits.inequalities)

    def build(self, kin: Kinematics) -> Problem:
        """Return the QP of the tick; its arrays are valid until the next call.

        Raises:
            TaskError: an attribute of a task has a wrong shape or type.
            ContactError: an attribute of a contact has.
            LimitError: an attribute of a limit has.
        """
        rows, constraints = self.contacts, self._constraints
        rows.write(kin)
        self.elimination.update(kin.mass_matrix, kin.bias_forces, rows.J, rows.a)
        self._upper.write(kin)
        H, g = self._cost.build(kin)
        C, lb, ub = constraints.build(kin)
        # A cost that is not finite shows in g: it is Gᵀ r with H = Gᵀ G, see `Cost`.
        finite = math.isfinite(g.dot(g)) and not math.isnan((ub - lb).min())
        finite = finite and bool(np.isfinite(self._G).all())
        bounded, levels = constraints.bounded, self._levels
        return Problem(H, g, C, lb, ub, bounded, self.equality, self.blocks, finite, levels)

    def recover(
        self,
        x: np.ndarray,
        kin: Kinematics,
        dt: float,
        source: CommandSource | None = None,
    ) -> Command | None:
        """Return the command of a solution; None when it is not finite.

        Args:
            x: (n,).
            kin: kinematics of the state that the QP was built for.
            dt: control period, s.
            source: controller that can explain the command.
        """
        m, x1 = self.elimination, self._x1
        x1[:-1] = x
        f = m.W @ x1
        wrenches = {}
        for contact, rows in self.contacts:
            wrenches[contact.name] = contact.wrench(f[rows])
        acceleration, tau = m.acceleration(x1), m.T @ x1
        if not (math.isfinite(tau.dot(tau)) and math.isfinite(acceleration.dot(acceleration))):
            return None
        if self._torque_limit is not None:  # the solver's tolerance may exceed them
            tau = np.clip(tau, -self._torque_limit.maximum, self._torque_limit.maximum)
        v, a = kin.state.v[6:], acceleration[6:]
        q_target = kin.state.q[7:] + dt * v + (0.5 * dt * dt) * a
        return Command(tau, acceleration, wrenches, q_target, v + dt * a, source=source)


def _stance_contact(contacts: Sequence[Contact]) -> Contact | None:
    """Return the first exact contact whose motion rows are those of a rigid frame."""
    for contact in contacts:
        rigid = contact.motion_size == 6 and type(contact).write is Contact.write
        if rigid and contact.motion_weight is None:
            return contact
    return None

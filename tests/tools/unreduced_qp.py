"""An independent reference for the controller's optimum: the unreduced problem, certified.

Nothing here is taken from `wbc.qp`. The unknowns are x = (v̇, f, τ); the dynamics, contact
Jacobians and bias accelerations come from fresh Pinocchio calls:

    min  ½ |G x − d|²   subject to   E x = e,   low ≤ C x ≤ high,

with G stacked from the tasks' rows, soft contacts and regularisation, E from
`M v̇ + h = Sᵀ τ + Jᵀ f`, exact contacts and exact tasks, C from cones, force, torque,
acceleration and general limits. `certified_qp` solves it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

import wbc
from wbc.contacts import Contact
from wbc.limits import AccelerationBound, Limit, LimitRows
from wbc.qp import Regularisation

_AXES = pin.ReferenceFrame.LOCAL


@dataclass
class ControllerSetup:
    """Tasks, contacts and limits of a controller."""

    robot: wbc.Robot
    tasks: list[wbc.Task]
    contacts: list[Contact]
    bounds: list[AccelerationBound]
    torque_limit: wbc.TorqueLimit | None
    limits: list[Limit] = field(default_factory=list)
    regularisation: Regularisation = field(default_factory=Regularisation)


@dataclass
class UnreducedQP:
    """The problem in x = (v̇, f, τ), unknowns and constraint rows scaled to the order of one.

    Attributes:
        scale: (n,) physical unknowns are `scale * x`.
        G: (k, n), `d` (k,): the cost.
        E: (p, n), `e` (p,): equalities, rows of unit norm.
        C: (m, n), `low`, `high` (m,): inequalities, rows of unit norm.
        e_norm: (p,) norms of the rows of E before scaling, likewise c_norm (m,).
        sizes: of v̇, f and τ.
        contacts: (name, rows of f) of each contact.
    """

    scale: np.ndarray
    G: np.ndarray
    d: np.ndarray
    E: np.ndarray
    e: np.ndarray
    C: np.ndarray
    low: np.ndarray
    high: np.ndarray
    e_norm: np.ndarray
    c_norm: np.ndarray
    sizes: tuple[int, int, int]
    contacts: list[tuple[str, slice]]

    def cost(self, x: np.ndarray) -> float:
        """Return the cost at scaled unknowns."""
        r = self.G.astype(np.longdouble) @ x - self.d
        return float(0.5 * r @ r)

    def unknowns_of(self, command: wbc.Command) -> np.ndarray:
        """Return the scaled unknowns of a command."""
        forces = [command.wrenches[name][: rows.stop - rows.start] for name, rows in self.contacts]
        return np.concatenate((command.acceleration, *forces, command.tau)) / self.scale

    def violation(self, x: np.ndarray) -> float:
        """Return the largest violation of a row, relative to its norm or to a larger bound."""
        y = self.C @ x
        gap = np.maximum(self.low - y, y - self.high)
        bound = np.where(np.isfinite(self.low), np.abs(self.low), 0.0)
        bound = np.maximum(bound, np.where(np.isfinite(self.high), np.abs(self.high), 0.0))
        worst = np.abs(self.E @ x - self.e) / np.maximum(1.0, np.abs(self.e))
        return float(max(worst.max(initial=0.0), (gap / np.maximum(1.0, bound)).max(initial=0.0)))


def unreduced_qp(setup: ControllerSetup, state: wbc.State) -> UnreducedQP:
    """Return the problem of one tick."""
    robot, model = setup.robot, setup.robot.model
    data = model.createData()
    pin.computeAllTerms(model, data, state.q, state.v)
    pin.forwardKinematics(model, data, state.q, state.v, np.zeros(model.nv))
    M = np.triu(data.M) + np.triu(data.M, 1).T
    h = data.nle.copy()
    kin = wbc.Kinematics(robot, state)
    nv, na = model.nv, model.nv - 6
    nf = sum(c.motion_size for c in setup.contacts)
    n = nv + nf + na
    cost, equal, inside = _RowStack(n), _RowStack(n), _RowStack(n)
    J = np.zeros((nf, nv))
    at, names = 0, []
    for contact in setup.contacts:
        frame, size = robot.frame_id(contact.frame), contact.motion_size
        rows = slice(at, at + size)
        J[rows] = pin.computeFrameJacobian(model, model.createData(), state.q, frame, _AXES)[:size]
        a = -contact.damping * pin.getFrameVelocity(model, data, frame, _AXES).vector[:size]
        a -= pin.getFrameClassicalAcceleration(model, data, frame, _AXES).vector[:size]
        if contact.motion_weight is None:
            equal.add(J[rows], 0, a, a)
        else:
            cost.add(J[rows], 0, a, a, np.full(size, contact.motion_weight))
        inside.add(contact.cone, nv + at, -np.inf, 0.0)
        inside.add(np.eye(1, 3, 2), nv + at, contact.min_force, contact.max_force)
        names.append((contact.name, rows))
        at += size
    dynamics = np.hstack((M, -J.T, -np.eye(nv)[:, 6:]))
    equal.add(dynamics, 0, -h, -h)
    for task in setup.tasks:
        A, b = np.zeros((task.size, nv)), np.zeros(task.size)
        task.write(kin, A, b)
        if task.priority == 0:
            equal.add(A, 0, b, b)
        else:
            cost.add(A, 0, b, b, task.weight)
    small = setup.regularisation
    cost.add(np.eye(na), 6, 0.0, 0.0, np.full(na, small.acceleration))
    cost.add(np.eye(nf), nv, 0.0, 0.0, np.full(nf, small.force))
    if setup.bounds:
        both = [bound.bounds(kin) for bound in setup.bounds]
        low = np.max([b[0] for b in both], axis=0)
        high = np.min([b[1] for b in both], axis=0)
        middle = 0.5 * (low + high)  # where limits exclude each other
        inside.add(
            np.eye(na), 6, np.where(low > high, middle, low), np.where(low > high, middle, high)
        )
    if setup.torque_limit is not None:
        inside.add(np.eye(na), nv + nf, -setup.torque_limit.maximum, setup.torque_limit.maximum)
    for limit in setup.limits:
        A, F = np.zeros((limit.size, nv)), np.zeros((limit.size, nf))
        columns = {c: F[:, rows] for c, (_, rows) in zip(setup.contacts, names, strict=True)}
        limited = LimitRows(A, np.full(limit.size, -np.inf), np.full(limit.size, np.inf), columns)
        limit.write(kin, limited)
        bounded = np.isfinite(limited.lower) | np.isfinite(limited.upper)
        rows = np.hstack((A, F))[bounded]
        inside.add(rows, 0, limited.lower[bounded], limited.upper[bounded])
    scale = np.concatenate((np.ones(nv), np.full(nf + na, robot.weight)))
    G, d, _ = cost.stacked()
    C, low, high = inside.stacked()
    same = low == high  # bounds that coincide make an equality
    equal.add(C[same], 0, low[same], high[same])
    C, low, high = C[~same], low[~same], high[~same]
    E, e, _ = equal.stacked()
    E, C = E * scale, C * scale
    p, m = (np.maximum(np.linalg.norm(A, axis=1), 1e-12) for A in (E, C))
    return UnreducedQP(
        *(scale, G * scale, d, E / p[:, None], e / p, C / m[:, None], low / m, high / m, p, m),
        (nv, nf, na),
        names,
    )


class _RowStack:
    """Rows `low ≤ A x[start:] ≤ high`, each multiplied by the root of its weight."""

    def __init__(self, n: int) -> None:
        self.n = n
        self.rows: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def add(self, A, start, low, high, weight=1.0) -> None:
        rows = np.zeros((A.shape[0], self.n))
        rows[:, start : start + A.shape[1]] = A
        root = np.sqrt(weight)
        wide = np.broadcast_to(root, A.shape[:1])
        self.rows.append(
            (wide[:, None] * rows, *(np.broadcast_to(b, A.shape[:1]) * wide for b in (low, high)))
        )

    def stacked(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return A, low and high of all rows."""
        if not self.rows:
            return np.zeros((0, self.n)), np.zeros(0), np.zeros(0)
        A, low, high = zip(*self.rows, strict=True)
        return np.vstack(A), np.concatenate(low), np.concatenate(high)

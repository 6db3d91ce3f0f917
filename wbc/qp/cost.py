"""The QP's cost: weighted tasks, soft contacts and regularisation as H and g."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wbc.contacts import Contact
from wbc.kinematics import Kinematics
from wbc.qp.contact_rows import ContactRows
from wbc.qp.elimination import Elimination
from wbc.qp.priorities import rows_of
from wbc.qp.row_errors import write_joint_rows, write_rows
from wbc.tasks import JointTask, Task

_ROOT_BASE = 1e-2  # of the weight on the base dynamics, 1/N


@dataclass(frozen=True, slots=True)
class Regularisation:
    """Small costs that make the optimum unique.

    Attributes:
        force: weight on every contact force and moment, 1/N² and 1/(N·m)².
        acceleration: weight on every joint acceleration, s⁴/rad².
    """

    force: float = 1e-6
    acceleration: float = 1e-6


class ResidualRows:
    """The weighted residuals `√w (A v̇ − b)` of tasks and soft contacts as rows G of x̂ = (x, 1).

    Args:
        members: tasks and soft contacts, in the order of their rows.
        contacts: the contacts.
        m: the formulation.
        out: (≥ rows, n + 1) to be written, from its first row on.
    """

    def __init__(
        self,
        members: Sequence[Task | Contact],
        contacts: ContactRows,
        m: Elimination,
        out: np.ndarray,
    ) -> None:
        self._m = m
        self._contacts = contacts
        size = sum(map(rows_of, members))
        self._G = out[:size]
        self._A = np.zeros((size, m.T.shape[0] + 6))
        self._b = np.zeros(size)
        self._root = np.zeros((size, 1))  # of the weights
        # Each task gets views into the stacked rows, made once.
        self._tasks, self._soft = [], []
        sources = dict(contacts)
        start = 0
        for member in members:
            rows = slice(start, start + rows_of(member))
            if isinstance(member, Task):
                self._tasks.append((member, self._A[rows], self._b[rows], self._root[rows, 0]))
            else:
                self._soft.append((member, sources[member], rows))
            start = rows.stop

    def write(self, kin: Kinematics) -> None:
        """Write the rows of this tick."""
        A, b, G = self._A, self._b, self._G
        for task, A_task, b_task, root in self._tasks:
            write_rows(task, kin, A_task, b_task)
            root[:] = task.sqrt_weight
        for contact, source, target in self._soft:
            A[target] = self._contacts.J[source]
            b[target] = self._contacts.a[source]
            self._root[target] = np.sqrt(contact.motion_weight or 0.0)
        self._m.project(A, G)
        G[:, -1] -= b
        G *= self._root


class Cost:
    """The sum `½ Σ w (A v̇ − b)²` over the tasks of the last level as `½ xᵀ H x + gᵀ x`.

    With the residual of all rows written `G x̂`, x̂ = (x, 1), the product `Gᵀ G` holds H and,
    in its last column, g. Tasks on single joints and the regularisation of unknowns only
    touch the diagonal.

    Args:
        members: weighted tasks and soft contacts.
        contacts: the contacts.
        m: the formulation.
        regularisation: small costs.
    """

    def __init__(
        self,
        members: Sequence[Task | Contact],
        contacts: ContactRows,
        m: Elimination,
        regularisation: Regularisation,
    ) -> None:
        n = m.n
        self._m = m
        joint_tasks = [t for t in members if isinstance(t, JointTask)]
        dense = [t for t in members if not isinstance(t, JointTask)]
        self._joint_tasks = [
            (t, _slice_if_possible(t.index + m.joints.start), np.zeros(t.size)) for t in joint_tasks
        ]
        # Residual rows G: those of tasks and soft contacts, then the eliminated forces.
        # Residual rows of the base dynamics are zero at every feasible point: where the QP holds
        # them as equalities they make H positive definite without moving the optimum.
        left, size = m.E.shape[0], sum(map(rows_of, dense))
        self._G = np.zeros((size + m.eliminated + left, n + 1))
        self._rows = ResidualRows(dense, contacts, m, self._G)
        self._force_rows = self._G[size : size + m.eliminated]
        self._base_rows = self._G[size + m.eliminated :]
        self._root_force = float(np.sqrt(regularisation.force))
        self._product = np.zeros((n + 1, n + 1))
        self._diagonal_cost = np.zeros(n)
        self._diagonal_cost[m.joints] = regularisation.acceleration
        self._diagonal_cost[m.free] = regularisation.force * m.unit**2
        self._H = np.zeros((n, n))
        self._g = np.zeros(n)
        self._diagonal = self._H.reshape(-1)[:: n + 1]

    def build(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        """Return H (n, n) and g (n,), valid until the next call."""
        m, G = self._m, self._G
        self._rows.write(kin)
        np.multiply(m.W[: m.eliminated], self._root_force, out=self._force_rows)
        np.multiply(m.E, _ROOT_BASE, out=self._base_rows)
        product, H, g, diagonal = self._product, self._H, self._g, self._diagonal
        np.dot(G.T, G, out=product)
        H[:] = product[:-1, :-1]
        g[:] = product[:-1, -1]
        diagonal += self._diagonal_cost
        for joint_task, index, b_joint in self._joint_tasks:
            write_joint_rows(joint_task, kin, b_joint)
            diagonal[index] += joint_task.weight
            g[index] -= joint_task.weight * b_joint
        return H, g


def _slice_if_possible(index: np.ndarray) -> np.ndarray | slice:
    """Return consecutive indices as a slice, which is several times faster."""
    if index.size and np.array_equal(index, np.arange(index[0], index[0] + index.size)):
        return slice(int(index[0]), int(index[0]) + index.size)
    return index

"""From tasks and limits to the QP of a velocity, in numpy: the reference of the compiled one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wbc.ik.configuration_kinematics import ConfigurationKinematics
from wbc.ik.errors import NoSolutionFound
from wbc.kinematics import Kinematics
from wbc.limits import Limit, LimitRows, LimitSet
from wbc.qp import Problem, non_finite_rows
from wbc.qp.row_errors import raise_row_error
from wbc.qp.rows import RowBlock
from wbc.robot import RobotModel
from wbc.tasks import PostureTask, Task


class Unknown(Enum):
    """What the rows of tasks ask for."""

    VELOCITY = "velocity"  #: v_ref + (kp/kd) e, the velocity of a control period
    DISPLACEMENT = "displacement"  #: e, the whole error, with dt = 1


@dataclass(frozen=True)
class VelocityProblemLayout:
    """The structure of a program: what it is made of.

    Attributes:
        robot: the robot.
        weighted: tasks in the cost.
        exact: tasks that hold as equalities.
        limits: limits, by kind; those on torques have no meaning here.
        columns: (n,) indices into nv of the coordinates that move, joints first.
        unknown: what the rows of tasks ask for.
        damping: cost of every unknown, s²/m² and s²/rad².
    """

    robot: RobotModel
    weighted: tuple[Task, ...]
    exact: tuple[Task, ...]
    limits: LimitSet
    columns: np.ndarray
    unknown: Unknown
    damping: float

    @property
    def joints(self) -> np.ndarray:
        """Indices into (na,) of the joints that move, in the order of the unknowns."""
        return self.columns[self.columns >= 6] - 6

    def blocks(self) -> tuple[RowBlock, ...]:
        """Return the names of the rows: bounds of joints and base, exact tasks, limits."""
        names = tuple(self.robot.joint_names[j] for j in self.joints)
        what = " or ".join(bound.name for bound in self.limits.bounds) or "joint velocity"
        blocks = [RowBlock(what, "rad/s", 0, len(names), names)] if names else []
        start = self.columns.size
        if start > len(names):
            blocks.append(RowBlock("base velocity", "m/s, rad/s", len(names), start))
        for task in self.exact:
            unit = task.unit.replace("/s²", "/s").replace("N·m", "kg·m²/s")
            blocks.append(RowBlock(task.name, unit, start, start + task.size, task.labels))
            start += task.size
        for limit in self.limits.inequalities:
            unit = limit.unit.replace("/s²", "/s")
            blocks.append(RowBlock(limit.name, unit, start, start + limit.size, limit.labels))
            start += limit.size
        return tuple(blocks)


class VelocityProgram:
    """Builds the QP of one layout: fixed lists of tasks, limits and coordinates that move.

        min ½ Σ w |J v − v_ref − (kp/kd) e|² + ½ damping |v|²
        s.t. the same rows of exact tasks as equalities, limits on v.

    Args:
        layout: what the program is made of.

    Attributes:
        errors: of a displacement: errors of the weighted tasks in the last `build`, those of
            postures last.
    """

    def __init__(self, layout: VelocityProblemLayout) -> None:
        self._layout = layout
        nv = layout.robot.nv
        self._weighted = [VelocityTaskRows(t, nv) for t in postures_last(layout.weighted)]
        self._exact = [VelocityTaskRows(t, nv) for t in layout.exact]
        self._inequalities = [
            limit_update(limit, np.zeros((limit.size, nv)), *np.zeros((2, limit.size)))
            for limit in layout.limits.inequalities
        ]
        self.errors = np.zeros(sum(task.size for task in layout.weighted))
        self._blocks = layout.blocks()
        n = layout.columns.size
        equalities = sum(rows.task.size for rows in self._exact)
        size = equalities + sum(limit.size for limit in layout.limits.inequalities)
        self._equality = np.zeros(n + size, dtype=bool)
        self._equality[n : n + equalities] = True

    def build(self, kin: ConfigurationKinematics, v: np.ndarray, dt: float) -> Problem:
        """Return the QP of a step.

        Args:
            kin: kinematics of the configuration.
            v: (na,) joint velocities before the step, rad/s.
            dt: duration of the step, s.

        Raises:
            TaskError: an attribute of a task has a wrong shape or type.
            LimitError: an attribute of a limit has.
        """
        layout, columns = self._layout, self._layout.columns
        n = columns.size
        H, g = layout.damping * np.eye(n), np.zeros(n)
        start = 0
        for rows in self._weighted:
            J, b = rows.write(kin, layout)
            self.errors[start : start + b.size] = b
            start += b.size
            JtW = J.T * rows.task.weight
            H += JtW @ J
            g -= JtW @ b
        lb, ub = np.full(n, -np.inf), np.full(n, np.inf)
        moving, joints = columns >= 6, layout.joints
        low, high = joint_velocity_bounds(layout.limits, kin, v, dt)
        lb[moving], ub[moving] = low[joints], high[joints]
        matrices, lower, upper = [np.zeros((0, n))], [lb], [ub]
        for rows in self._exact:
            J, b = rows.write(kin, layout)
            matrices.append(J)
            lower.append(b)
            upper.append(b)
        for update in self._inequalities:
            written = update(kin, dt)
            matrices.append(written.A[:, columns])
            lower.append(written.lower)
            upper.append(written.upper)
        C, lb, ub = np.vstack(matrices), np.concatenate(lower), np.concatenate(upper)
        finite = np.isfinite(g).all() and np.isfinite(C).all() and not np.isnan(ub - lb).any()
        return Problem(H, g, C, lb, ub, n, self._equality, self._blocks, bool(finite))


def postures_last(tasks: Sequence[Task]) -> list[Task]:
    """Return tasks in the order of their rows: those on single joints last."""
    return sorted(tasks, key=lambda task: isinstance(task, PostureTask))


def weighted_squares(tasks: Sequence[Task], errors: np.ndarray) -> float:
    """Return Σ w e² of the errors of a program's weighted tasks."""
    weights = np.concatenate([task.weight for task in postures_last(tasks)])
    return float(errors.dot(weights * errors))


class VelocityTaskRows:
    """The rows of a task at velocity level."""

    def __init__(self, task: Task, nv: int) -> None:
        self.task = task
        self._J = np.zeros((task.size, nv))
        self._velocity, self._error = np.zeros(task.size), np.zeros(task.size)

    def write(
        self, kin: Kinematics, layout: VelocityProblemLayout
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the coefficients of the unknowns (m, n), and what is asked for (m,)."""
        task, velocity, error = self.task, self._velocity, self._error
        try:
            task.write_velocity(kin, self._J, velocity, error)
        except (ValueError, TypeError, AttributeError) as failure:
            raise_row_error(task, failure)
        asked = error if layout.unknown is Unknown.DISPLACEMENT else 0.0
        if layout.unknown is Unknown.VELOCITY:
            asked = velocity + task.velocity_gain * error
        return self._J[:, layout.columns], np.array(asked)


def limit_update(
    limit: Limit, A: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> Callable[[Kinematics, float], LimitRows]:
    """Return a function that writes the rows of a general limit into these arrays."""
    rows = LimitRows(A, lower, upper, {})

    def update(kin: Kinematics, dt: float) -> LimitRows:
        rows.clear()
        try:
            limit.write_velocity(kin, dt, rows)
        except (ValueError, TypeError, AttributeError) as failure:
            raise_row_error(limit, failure)
        return rows

    return update


def joint_velocity_bounds(
    limits: LimitSet, kin: Kinematics, v: np.ndarray, dt: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the joint velocities that all limits on joints allow, (na,) each.

    Where limits exclude each other, the first holds, see `LimitSet`.
    """
    lower, upper = np.full(v.size, -np.inf), np.full(v.size, np.inf)
    for bound in limits.bounds:
        low, high = bound.velocity_bounds(kin, v, dt)
        lower, upper = np.clip(low, lower, upper), np.clip(high, lower, upper)
    return lower, upper


def non_finite_error(
    kin: ConfigurationKinematics, tasks: Sequence[Task], limits: LimitSet
) -> NoSolutionFound:
    """Return the error of a problem that is not finite, with the task or limit at fault."""
    found = non_finite_rows(kin, tasks, (), limits)
    return NoSolutionFound(found or "the QP is not finite: a weight is NaN or infinite")

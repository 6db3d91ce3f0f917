"""Explains a tick: what tasks asked for and got, what stood in their way, and what it costs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from wbc.kinematics import Kinematics
from wbc.qp.explanation import ConflictingRow
from wbc.qp.multipliers import LevelMultipliers
from wbc.qp.problem import Problem
from wbc.qp.row_errors import write_rows
from wbc.qp.rows import RowBlock
from wbc.tasks import MotionTask, Task
from wbc.tasks.motion import CENTROID

_SHORTFALL = 1e-3  # of an acceleration that is worth a line
_SHARE = 0.02  # of a row's cost, for a task that is worth naming
_LINES = 4  # rows of a task, and tasks of a row, in the text
_ROWS = 10  # limits and contact rows in the text


@dataclass(frozen=True, slots=True)
class TaskResult:
    """What a task asked for and got.

    Attributes:
        name: the task's.
        priority: its level; 0 exact.
        labels: one text per row.
        units: one per row.
        asked: (m,) desired acceleration, the bias J̇ v of the motion included.
        got: (m,) acceleration of the command.
    """

    name: str
    priority: int
    labels: tuple[str, ...]
    units: tuple[str, ...]
    asked: np.ndarray
    got: np.ndarray

    def __str__(self) -> str:
        level = "exact" if self.priority == 0 else f"priority {self.priority}"
        off = np.abs(self.got - self.asked)
        order = [int(i) for i in np.argsort(-off, kind="stable") if off[i] > _SHORTFALL]
        texts = [
            f"{self.labels[i]} asked {self.asked[i]:.3g}, got {self.got[i]:.3g} {self.units[i]}"
            for i in order[:_LINES]
        ]
        if len(order) > _LINES:
            texts.append(f"{len(order) - _LINES} more rows")
        return f"{self.name} ({level}): {'; '.join(texts) or 'got what it asked for'}"


@dataclass(frozen=True, slots=True)
class TaskGain:
    """What a task would gain if a row gave way by one unit.

    Attributes:
        name: label of the task's row that gains most, e.g. "com [x]".
        unit: of the task's row.
        change: of the acceleration of that row, towards what was asked.
        share: of the row's cost that is this task's.
    """

    name: str
    unit: str
    change: float
    share: float


@dataclass(frozen=True, slots=True)
class ActiveRow:
    """A limit or contact row at its bound.

    Attributes:
        name: label of the row, e.g. "torque limit [leg_left_4_joint]".
        unit: of the row's values.
        at_maximum: whether it is at the upper bound.
        priority: the highest level that the row stands in the way of; 0 when in that of none.
        multiplier: by how much the cost of that level would fall per unit.
        gains: tasks of that level that would gain, the largest share first.
    """

    name: str
    unit: str
    at_maximum: bool
    priority: int
    multiplier: float
    gains: tuple[TaskGain, ...]

    def __str__(self) -> str:
        side = "maximum" if self.at_maximum else "minimum"
        text = f"{self.name} is at its {side}"
        if self.priority == 0:
            return f"{text} and in the way of no task"
        text += f"; giving way by one {self.unit} saves {self.multiplier:.2g}"
        text += f" of the cost of priority {self.priority}"
        gains = [f"{g.name} {g.change:.2g} {g.unit}" for g in self.gains[:_LINES]]
        return f"{text} and brings {', '.join(gains)} closer to what is asked" if gains else text


@dataclass(frozen=True, slots=True)
class TickExplanation:
    """Why a command is what it is.

    Attributes:
        reason: why there is no solution, see `Command.explanation`; empty when there is one.
        conflict: rows that cannot hold together, and by how much each has to give way, see
            `wbc.qp.find_conflict`; empty when there is a solution, or the solver just gave up.
        tasks: what each task asked for and got; empty when there is no solution.
        active: limits and contact rows at a bound, those that cost the highest level most first.
    """

    reason: str
    conflict: tuple[ConflictingRow, ...]
    tasks: tuple[TaskResult, ...]
    active: tuple[ActiveRow, ...]

    def __str__(self) -> str:
        if self.reason:
            return self.reason
        lines = ["tasks:", *(f"  {task}" for task in self.tasks)]
        felt = [row for row in self.active if row.gains]
        if felt:
            lines += ["in the way:", *(f"  {row}" for row in felt[:_ROWS])]
        if len(felt) > _ROWS:
            lines.append(f"  and {len(felt) - _ROWS} more rows")
        return "\n".join(lines)


def explain_solution(
    problem: Problem,
    x: np.ndarray,
    tasks: Sequence[Task],
    kin: Kinematics,
    acceleration_of: Callable[[np.ndarray], np.ndarray],
) -> TickExplanation:
    """Return the explanation of a solved problem.

    A row i that holds level k keeps the change A dv̇ per unit from a task with rows A. The optimum
    of the level moves with the row's bound by dx, `[H_k Nᵀ; N 0] (dx, dμ) = (0, e_i)`, with N the
    rows that hold the level, as long as these stay the same (Fiacco, Sensitivity analysis for
    nonlinear programming using penalty methods, Mathematical Programming 1976).

    Args:
        problem: the QP.
        x: (n,) its solution.
        tasks: the tasks, in any order.
        kin: kinematics that the problem was made of.
        acceleration_of: from x to the generalised acceleration (nv,).
    """
    acceleration = acceleration_of(x)
    rows = [_TaskRows(task, kin) for task in tasks]
    results = tuple(r.result(acceleration) for r in rows)
    multipliers = LevelMultipliers(problem, x)
    if problem.levels is not None:
        priorities = problem.levels.priorities
    else:
        priorities = (max((task.priority for task in tasks), default=0) or 1,)
    blocks = [block for block in problem.blocks for _ in range(block.start, block.stop)]
    active: dict[int, ActiveRow] = {}
    for k in range(1, multipliers.count + 1):
        held = np.flatnonzero(multipliers.holding_rows(k))
        pushed = multipliers.values[k - 1] != 0.0
        wanted = [
            int(row)
            for row in held
            if pushed[row] and not problem.equality[row] and row not in active
        ]
        if not wanted:
            continue
        moves = _sensitivity(problem, multipliers, k, held, wanted)
        of_level = [r for r in rows if r.task.priority == priorities[k - 1]]
        for row, dx in zip(wanted, moves, strict=True):
            force = float(multipliers.values[k - 1, row])
            towards = np.sign(force)
            change = towards * (acceleration_of(x + dx) - acceleration)
            gains = [r.gain(acceleration, change, abs(force)) for r in of_level]
            gains = sorted((g for g in gains if g.share > _SHARE), key=lambda g: -g.share)
            name, unit = blocks[row].label(row), blocks[row].unit_of(row)
            of = priorities[k - 1]
            active[row] = ActiveRow(name, unit, force > 0.0, of, abs(force), tuple(gains))
    for row in np.flatnonzero(multipliers.at_bound & ~problem.equality):
        if int(row) not in active:
            name, unit = blocks[row].label(row), blocks[row].unit_of(row)
            active[int(row)] = ActiveRow(name, unit, bool(multipliers.at_upper[row]), 0, 0.0, ())
    ordered = sorted(active.values(), key=lambda r: (r.priority or np.inf, -r.multiplier))
    return TickExplanation("", (), results, tuple(ordered))


def _sensitivity(
    problem: Problem, multipliers: LevelMultipliers, k: int, held: np.ndarray, wanted: list[int]
) -> np.ndarray:
    """Return by how much the optimum of level k moves per unit of some bounds, (len(wanted), n)."""
    n = problem.g.size
    A = np.vstack((np.eye(problem.bounded, n), problem.C))[held]
    upper = multipliers.upper_rows(k)
    N = np.vstack((A, upper))
    norm = np.maximum(np.linalg.norm(N, axis=1), 1e-9)
    N = N / norm[:, None]
    H = multipliers.hessian(k)
    scale = max(float(np.abs(H).max()), 1e-12)
    size = N.shape[0]
    K = np.zeros((n + size, n + size))
    K[:n, :n], K[:n, n:], K[n:, :n] = H / scale, N.T, N
    right = np.zeros((n + size, len(wanted)))
    for column, row in enumerate(wanted):
        place = int(np.flatnonzero(held == row)[0])
        right[n + place, column] = 1.0 / norm[place]
    return np.asarray(np.linalg.lstsq(K, right, rcond=1e-12)[0][:n].T)


class _TaskRows:
    """The rows of a task in this tick."""

    def __init__(self, task: Task, kin: Kinematics) -> None:
        self.task = task
        self.A, self.b = np.zeros((task.size, kin.model.nv)), np.zeros(task.size)
        write_rows(task, kin, self.A, self.b)
        self.bias = np.zeros(task.size)
        if isinstance(task, MotionTask):
            centroid = task.frame_id == CENTROID
            motion = kin.centroid if centroid else kin.motion(task.frame_id)
            self.bias = motion.bias[task.components]
        self._block = RowBlock(task.name, task.unit, 0, task.size, task.labels)

    def result(self, acceleration: np.ndarray) -> TaskResult:
        task = self.task
        labels = task.labels or tuple(f"[{i}]" for i in range(task.size))
        units = tuple(self._block.unit_of(i) for i in range(task.size))
        asked, got = self.b + self.bias, self.A @ acceleration + self.bias
        return TaskResult(task.name, task.priority, labels, units, asked, got)

    def gain(self, acceleration: np.ndarray, change: np.ndarray, force: float) -> TaskGain:
        off = self.A @ acceleration - self.b
        moved = self.A @ change
        saved = -self.task.weight * off * moved
        row = int(np.argmax(saved))
        towards = float(-np.sign(off[row]) * moved[row])
        share = float(saved.sum()) / max(force, 1e-12)
        return TaskGain(self._block.label(row), self._block.unit_of(row), towards, share)

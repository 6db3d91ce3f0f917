"""The QP of a velocity with strict priorities: the rows of the upper levels beside the program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wbc.ik.compiled_program import CompiledVelocityProgram
from wbc.ik.configuration_kinematics import ConfigurationKinematics
from wbc.ik.velocity_program import VelocityProblemLayout, VelocityTaskRows
from wbc.qp import Problem
from wbc.qp.priorities import PriorityOrder
from wbc.tasks import Task


class PrioritizedVelocityProgram:
    """Builds the problem of one layout whose weighted tasks are those of the last level.

    Args:
        layout: the last level, exact tasks and limits.
        order: which task is of which level.
    """

    def __init__(self, layout: VelocityProblemLayout, order: PriorityOrder) -> None:
        self._layout = layout
        self._last = CompiledVelocityProgram(layout)
        tasks = [m for members in order.upper for m in members if isinstance(m, Task)]
        self._G = np.zeros((sum(task.size for task in tasks), layout.columns.size + 1))
        self._rows = []
        start = 0
        for task in tasks:
            rows = self._G[start : start + task.size]
            self._rows.append((VelocityTaskRows(task, layout.robot.nv), rows))
            start += task.size
        self._levels = order.levels(self._G, layout.blocks(), layout.limits.inequalities)

    def build(self, kin: ConfigurationKinematics, v: np.ndarray, dt: float) -> Problem:
        """Return the problem of a step; see `wbc.ik.velocity_program.VelocityProgram.build`."""
        problem = self._last.build(kin, v, dt)
        for task_rows, out in self._rows:
            J, b = task_rows.write(kin, self._layout)
            root = task_rows.task.sqrt_weight
            out[:, :-1] = J * root[:, None]
            out[:, -1] = -root * b
        finite = problem.finite and bool(np.isfinite(self._G).all())
        return replace(problem, finite=finite, levels=self._levels)

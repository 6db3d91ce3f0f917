"""Tasks that have a share of their usual weight for a while."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wbc.tasks import Task


class WeightShare:
    """Gives some tasks a share of their usual weight, and the usual one back.

    A weight that is set meanwhile stays as it is set.

    Args:
        tasks: the tasks.
    """

    def __init__(self, tasks: Sequence[Task]) -> None:
        self._tasks = tuple(tasks)
        self._share: float | tuple[float, ...] = 1.0
        self._changed: list[
            tuple[Task, np.ndarray, np.ndarray]
        ] = []  # usual weight and that of now

    def set(self, share: float | tuple[float, ...]) -> None:
        """Set the share, one for all rows or one for each; 1 is the usual weight."""
        if share == self._share:
            return
        for task, usual, changed in self._changed:
            if task.weight is changed:
                task.weight = usual
        self._changed.clear()
        self._share = share
        if share == 1.0:
            return
        for task in self._tasks:
            usual = task.weight
            task.weight = np.multiply(share, usual)
            self._changed.append((task, usual, task.weight))

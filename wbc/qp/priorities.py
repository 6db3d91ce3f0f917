"""Sorts tasks, soft contacts and limits into levels of strict priority."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wbc.contacts import Contact
from wbc.limits import Limit, LimitSet
from wbc.qp.levels import Levels
from wbc.qp.rows import RowBlock
from wbc.tasks import Task


@dataclass(frozen=True, eq=False)
class PriorityOrder:
    """Who belongs to which level.

    Attributes:
        exact: tasks of priority 0, which hold exactly.
        upper: tasks and soft contacts of each level but the last.
        last: tasks and soft contacts of the last level, which becomes the cost of the QP.
        priorities: the priority that stands for each level.
    """

    exact: tuple[Task, ...]
    upper: tuple[tuple[Task | Contact, ...], ...]
    last: tuple[Task | Contact, ...]
    priorities: tuple[int, ...]

    @classmethod
    def sort(
        cls, tasks: Sequence[Task], contacts: Sequence[Contact], limits: LimitSet
    ) -> PriorityOrder:
        """Return the order; soft contacts belong to the first level.

        Args:
            tasks: all tasks.
            contacts: all contacts.
            limits: limits, by kind.

        Raises:
            TaskError: a task's priority was set to something else than a whole number from 0 on.
        """
        for task in tasks:
            task.check_priority()
        given = {task.priority for task in tasks} | {b.priority for b in limits.inequalities}
        priorities = tuple(sorted(given - {0})) or (1,)
        soft = [c for c in contacts if c.motion_weight is not None]
        members: list[tuple[Task | Contact, ...]] = []
        for priority in priorities:
            level: list[Task | Contact] = [t for t in tasks if t.priority == priority]
            members.append((*level, *soft) if priority == priorities[0] else tuple(level))
        exact = tuple(t for t in tasks if t.priority == 0)
        return cls(exact, tuple(members[:-1]), members[-1], priorities)

    def levels(
        self, G: np.ndarray, blocks: Sequence[RowBlock], limits: Sequence[Limit]
    ) -> Levels | None:
        """Return what a `Problem` tells of the levels; None when there is one cost only.

        Args:
            G: residual rows, those of the upper levels first.
            blocks: names of all constraints; those of general limits bear the limits' names.
            limits: the general limits.
        """
        soft = {limit.name: limit for limit in limits if limit.priority > 0}
        if not (self.upper or soft):
            return None
        sizes = [sum(map(rows_of, members)) for members in self.upper]
        starts = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
        level = np.zeros(blocks[-1].stop, dtype=np.int64)
        weight = np.ones(blocks[-1].stop)
        for block in blocks:
            limit = soft.get(block.name)
            if limit is not None:
                rows = slice(block.start, block.stop)
                level[rows] = self.priorities.index(limit.priority) + 1
                weight[rows] = limit.weight
        return Levels(G, starts, level, weight, self.priorities)


def rows_of(item: Task | Contact) -> int:
    """Return how many rows of the cost a task or soft contact has."""
    return item.size if isinstance(item, Task) else item.motion_size

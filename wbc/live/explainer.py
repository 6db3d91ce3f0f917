"""Explains a tick to the pages: it is solved again alone, beside the loop."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from wbc.errors import WbcError
from wbc.qp.inputs import packed_text, packed_values
from wbc.runtime.controller_inputs import NAME
from wbc.state import State

if TYPE_CHECKING:
    from wbc.qp import TickExplanation
    from wbc.robot import Robot

PageT = TypeVar("PageT")
_MISSED = 1e-3  # of an acceleration that is worth a line
_ROWS, _LIMITS, _GAINS = 6, 12, 3  # lines of a task, limits, and tasks that gain from one


class TickExplainer(Generic[PageT]):
    """Explains ticks in a thread, one after the other.

    Args:
        robot: The robot of the ticks.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._thread = ThreadPoolExecutor(1)
        self._waiting: dict[PageT, Future[dict[str, Any]]] = {}

    def request(self, record: Any, page: PageT) -> None:
        """Explain the tick of a record to a page, unless the page waits for an answer already."""
        if page not in self._waiting:
            self._waiting[page] = self._thread.submit(self.explain, record)

    def answers(self) -> list[tuple[PageT, dict[str, Any]]]:
        """Return what has been found out since the last call, and for whom."""
        ready = [page for page, answer in self._waiting.items() if answer.done()]
        return [(page, self._waiting.pop(page).result()) for page in ready]

    def explain(self, record: Any) -> dict[str, Any]:
        """Return the explanation of a record's tick as JSON, or why there is none."""
        from wbc.recorded_tick import recorded_controller  # here, because it takes long to load

        time = {"time": round(float(record["time"]), 4)}
        try:
            words = record[NAME]
            controller = recorded_controller(self._robot, packed_text(words), packed_values(words))
            command = controller.step(State(np.array(record["q"]), np.array(record["v"])))
            return {**time, **_as_json(command.explain())}
        except (WbcError, ValueError, KeyError) as error:
            return {**time, "error": str(error)}


def _as_json(why: TickExplanation) -> dict[str, Any]:
    return {
        "reason": why.reason,
        "conflict": [str(row) for row in why.conflict],
        "tasks": [
            {"name": task.name, "priority": task.priority, "rows": _missed(task)}
            for task in why.tasks
        ],
        "limits": [
            {
                "name": row.name,
                "side": "maximum" if row.at_maximum else "minimum",
                "cost": _short(row.multiplier),
                "unit": row.unit,
                "priority": row.priority,
                "gains": [[g.name, _short(g.change), g.unit] for g in row.gains[:_GAINS]],
            }
            for row in why.active[:_LIMITS]
        ],
    }


def _missed(task: Any) -> list[list[Any]]:
    """Return label, asked, got and unit of the rows of a task, the largest differences first."""
    off = np.abs(task.got - task.asked)
    order = [int(i) for i in np.argsort(-off, kind="stable") if off[i] > _MISSED]
    return [
        [task.labels[i], _short(task.asked[i]), _short(task.got[i]), task.units[i]]
        for i in order[:_ROWS]
    ]


def _short(value: float) -> float:
    return float(f"{float(value):.3g}")

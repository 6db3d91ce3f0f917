"""The events of a session, for the marks that the page shows over time."""

from __future__ import annotations

import json
from typing import Any

from wbc.live.history import History
from wbc.runtime.event import COMMAND, FALL
from wbc.runtime.event_queue import EventQueue, NumberedEvent

_KEPT = 1000
_UNMARKED = (
    "velocity",
    "pause",
    "hand_target",
)  # commands without a mark: there are too many of them


class RunEvents:
    """Receives the events of the loop, and keeps the last ones.

    Args:
        descriptor: File descriptor of the queue of events.
        history: Knows when each run began.

    Attributes:
        fall: Why the robot fell last; empty if it has not.
    """

    def __init__(self, descriptor: int, history: History) -> None:
        self._queue, self._history = EventQueue(descriptor), history
        self._waiting: list[NumberedEvent] = []  # for the first tick of their run
        self._events: list[tuple[float, NumberedEvent]] = []  # with their session times, s
        self.fall = ""

    def take(self) -> list[dict[str, Any]]:
        """Return the marks of the events since the last call, as JSON."""
        waiting, self._waiting = [*self._waiting, *self._queue.take()], []
        new = []
        for one in waiting:
            if one.event.kind == FALL:
                self.fall = one.event.reason
            start = self._history.starts.get(one.run)
            if start is None:
                self._waiting.append(one)
            else:
                new.append((start + one.event.time, one))
        self._events = [*self._events, *new][-_KEPT:]
        return _marks(new)

    @property
    def all(self) -> list[dict[str, Any]]:
        """The marks of the events that are kept, as JSON."""
        return _marks(self._events)

    def between(self, start: float, end: float) -> list[tuple[float, NumberedEvent]]:
        """Return the events between two session times, s, with their times."""
        return [(time, one) for time, one in self._events if start <= time <= end]


def _marks(events: list[tuple[float, NumberedEvent]]) -> list[dict[str, Any]]:
    marks = []
    for time, (_, event) in events:
        kind, text = event.kind, event.reason
        if kind == COMMAND:
            if event.outcome != "accepted" or event.name in _UNMARKED:
                continue
            kind, text = event.name, _words(event.value)
        marks.append({"time": round(time, 3), "kind": kind.replace("_", " "), "text": text})
    return marks


def _words(value: str) -> str:
    """Return the values of a command in a few words."""
    parts = json.loads(value) if value.startswith("{") and value.endswith("}") else {}
    shown = {k: v for k, v in parts.items() if v is not None and k not in ("duration", "frame")}
    return ", ".join(f"{k.replace('_', ' ')} {v}" for k, v in shown.items())[:120]

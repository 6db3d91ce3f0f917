"""Events of a run: what was done to the robot, and what happened to it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

COMMAND, FALLING, FALL, RESET, SAFETY = "command", "falling", "fall", "reset", "safety"


@dataclass(frozen=True, slots=True)
class RunEvent:
    """Something that was done to the robot, or that happened to it.

    Attributes:
        time: plant time, s.
        kind: "command"; "falling", when the controller finds a fall unavoidable; "fall"; "reset",
            at the beginning of the run that follows; or "safety", a transition of the safety
            layer.
        source: sender of a command, e.g. "page", "ros" or "script".
        number: number of a command, unique per sender.
        name: name of a command, e.g. "velocity" or "push", or of a state of the safety layer.
        value: values of a command, as JSON.
        outcome: outcome of a command, see `wbc.teleop.CommandOutcome`.
        reason: why, unless a command was accepted or done.
    """

    time: float
    kind: str
    source: str = ""
    number: int = 0
    name: str = ""
    value: str = ""
    outcome: str = ""
    reason: str = ""


@runtime_checkable
class EventObserver(Protocol):
    """An observer of a run that is told its events, e.g. a log."""

    def on_event(self, event: RunEvent) -> None:
        """Process an event, without waiting: it may come inside a tick."""


@runtime_checkable
class EventSource(Protocol):
    """A plant that has events of its own, e.g. the transitions of its safety layer.

    Attributes:
        emit: is called with each of them; `wbc.run` sets it.
    """

    emit: Callable[[RunEvent], object]


def tell(observers: Iterable[object], event: RunEvent) -> None:
    """Tell an event to those observers that want to know."""
    for observer in observers:
        if isinstance(observer, EventObserver):
            observer.on_event(event)

"""Writes the events of a run as messages, at the stamps of the ticks around them."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from wbc.log.mcapfile import McapFile
from wbc.messages import message_type
from wbc.runtime.event import COMMAND, RunEvent
from wbc.runtime.event_queue import NumberedEvent

EVENTS, PARAMETERS = "/events", "/parameter_events"
_EVENT = message_type("wbc_msgs/msg/RunEvent")
_PARAMETER_EVENT = message_type("rcl_interfaces/msg/ParameterEvent")
_PARAMETER = message_type("rcl_interfaces/msg/Parameter")
_LAST_TICK = 0.02  # s: at its end a run is that much later than its last tick, or less
_DOUBLE = 3  # type of a parameter


class EventLog:
    """Writes events to a log, each after the tick before which it happened.

    Args:
        file: File of the log.
        take: Returns the events since its last call.
    """

    def __init__(self, file: McapFile, take: Callable[[], Sequence[NumberedEvent]]) -> None:
        self._file, self._take = file, take
        self._waiting: list[NumberedEvent] = []
        self._starts: dict[int, int] = {}  # stamp, ns, of the time 0 of each run
        self._now = (0, 0.0)  # run and time of the last tick

    def on_ticks(self, records: np.ndarray, stamps: np.ndarray) -> None:
        """Note the stamps, ns, of the ticks that have been written."""
        runs, first = np.unique(records["run"], return_index=True)
        for run, index in zip(runs.tolist(), first.tolist(), strict=True):
            start = int(stamps[index]) - round(1e9 * float(records["time"][index]))
            self._starts.setdefault(int(run), start)
        self._now = (int(records["run"][-1]), float(records["time"][-1]) + _LAST_TICK)

    def advance(self) -> None:
        """Write the events up to the last tick."""
        waiting, self._waiting = [*self._waiting, *self._take()], []
        for one in waiting:
            if (one.run, one.event.time) <= self._now:
                self._write(one)
            else:
                self._waiting.append(one)

    def finish(self) -> None:
        """Write the events that have come after the last tick."""
        for one in (*self._waiting, *self._take()):
            self._write(one)
        self._waiting.clear()

    def _write(self, one: NumberedEvent) -> None:
        start = self._starts.get(one.run, max(self._starts.values(), default=0))
        event = one.event
        stamp = max(start + round(1e9 * event.time), 0)
        message = _EVENT(
            kind=event.kind,
            source=event.source,
            number=event.number,
            name=event.name,
            value=event.value,
            outcome=event.outcome,
            reason=event.reason,
        )
        self._write_message(EVENTS, stamp, message)
        parameter = _parameter(event)
        if parameter is not None:
            changed = _PARAMETER_EVENT(node=event.source, changed_parameters=[parameter])
            self._write_message(PARAMETERS, stamp, changed)

    def _write_message(self, topic: str, stamp: int, message: Any) -> None:
        message.stamp.sec, message.stamp.nanosec = divmod(stamp, 1_000_000_000)
        self._file.write_message(topic, stamp, message)


def _parameter(event: RunEvent) -> Any | None:
    """Return the parameter that an event has changed; None if it has changed none."""
    if event.kind != COMMAND or event.outcome != "accepted":
        return None
    values = json.loads(event.value)
    match event.name:
        case "gait_parameter":
            name, value = f"gait.{values['name']}", values["value"]
        case "gain":
            name, value = f"{values['task']}.{values['gain']}", values["value"]
        case "time_scale":
            name, value = "speed", values["scale"]
        case _:
            return None
    parameter = _PARAMETER(name=name)
    parameter.value.type, parameter.value.double_value = _DOUBLE, float(value)
    return parameter

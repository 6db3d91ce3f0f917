"""The signals that pages draw over time: their past, and what follows."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

import numpy as np

from wbc.errors import did_you_mean, short_repr
from wbc.live.history import History
from wbc.live.signals import signal_limits, signal_places
from wbc.robot import Robot
from wbc.runtime.schema import Schema
from wbc.teleop import CommandRefused

_MAX_SIGNALS = 64  # of a page
_POINTS = 1500  # of the older and of the newer half of a signal's past

PageT = TypeVar("PageT")


class SignalStreams(Generic[PageT]):
    """Finds the samples of the signals that each page draws.

    Args:
        robot: The robot.
        dt: Control period, s.
        history: The samples.

    Attributes:
        schema: Schema of the ticks; assign it with `change_schema`.
    """

    def __init__(self, robot: Robot, dt: float, history: History) -> None:
        self._robot, self._dt, self._history = robot, dt, history
        self.schema = Schema(())
        self._places: dict[str, int] = {}
        self._chosen: dict[PageT, list[str]] = {}
        self._sent = 0  # number of the samples that the pages have received

    def change_schema(self, schema: Schema) -> None:
        """Offer the signals of another schema; pages go on with those that it has too."""
        self.schema, self._places = schema, signal_places(schema)
        for page, labels in self._chosen.items():
            self._chosen[page] = [label for label in labels if label in self._places]

    def offer(self) -> dict[str, Any]:
        """Return the names of the signals and their limits, as JSON."""
        limits = signal_limits(self.schema, self._robot, self._dt)
        return {"signals": list(self._places), "limits": limits}

    def choose(self, page: PageT, labels: Any) -> dict[str, Any]:
        """Note which signals a page draws; return their past, as JSON.

        Raises:
            CommandRefused: They are no names of signals, or too many.
        """
        if not isinstance(labels, list) or not all(isinstance(label, str) for label in labels):
            raise CommandRefused(f"signals are {short_repr(labels)}; they are a list of names")
        if len(labels) > _MAX_SIGNALS:
            raise CommandRefused(f"a page draws at most {_MAX_SIGNALS} signals")
        for label in labels:
            if label not in self._places:
                near = did_you_mean(label, self._places)
                raise CommandRefused(f"no signal {short_repr(label)}{near}")
        self._chosen[page] = labels
        return {"past": self._series(labels, 0)} if labels else {}

    def remove(self, page: PageT) -> None:
        """Forget a page that has been closed."""
        self._chosen.pop(page, None)

    def new_points(self) -> dict[PageT, dict[str, Any]]:
        """Return the samples since the last call for each page that draws signals, as JSON."""
        since, self._sent = self._sent, self._history.count
        if since == self._sent:
            return {}
        return {
            page: {"points": self._series(labels, since)}
            for page, labels in self._chosen.items()
            if labels
        }

    def _series(self, labels: list[str], since: int) -> dict[str, Any]:
        """Return signals over time, from the sample of a number on, as JSON."""
        places = [self._places[label] for label in labels]
        found = self._history.series(places, since, _POINTS)
        values = {
            label: [_numbers(one.low), _numbers(one.high)]
            for label, one in zip(labels, found, strict=True)
        }
        return {"time": np.round(found[0].time, 4).tolist() if found else [], "values": values}


def _numbers(values: np.ndarray) -> list[float | None]:
    """Return numbers for JSON, to seven digits; None for unknown ones."""
    return [float(f"{x:.7g}") if np.isfinite(x) else None for x in values.tolist()]

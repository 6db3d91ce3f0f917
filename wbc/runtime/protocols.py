"""What may take part in a run: controllers, plants, estimators and observers of any make."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from wbc.command import Command
from wbc.estimation import Estimate
from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.runtime.report import Report
from wbc.runtime.snapshot import Snapshot
from wbc.runtime.tick import Tick
from wbc.state import State


class Controller(Protocol):
    """Anything that turns states into commands runs in `run`.

    A controller may also have `telemetry`, `balance` (the part of it that is cheap enough for
    every tick), `dcm_error` (m) and `steps`: they are shown, logged and reported when they are
    there.
    """

    def reset(self, state: State) -> None:
        """Start anew from a state."""

    def step(self, estimate: Estimate) -> Command:
        """Return the command of one tick."""


class Plant(Protocol):
    """Anything that can be measured and commanded runs in `run`.

    A plant may also have `ground_truth() -> State`: falls, distances and joint limits are then
    judged on it instead of on the estimate. The estimate never sees it.
    """

    robot: Robot
    dt: float

    @property
    def time(self) -> float:
        """s since the last reset."""

    def measure(self) -> Measurement:
        """Sensor readings now."""

    def step(self, command: Command) -> None:
        """Hold a command for one control period."""


class StateEstimator(Protocol):
    """Turns measurements into estimates of state, contacts and foot loads."""

    def reset(self, state: State) -> None:
        """Start anew at a known state."""

    def update(
        self, measurement: Measurement, *, acceleration: np.ndarray | None = None
    ) -> Estimate:
        """Return the estimate now.

        Args:
            measurement: of this tick.
            acceleration: (nv,) what the last command was to bring about, m/s² and rad/s².
        """


class Observer(Protocol):
    """A viewer or recording: gets a snapshot after ticks, and never waits."""

    def show(self, snapshot: Snapshot) -> None:
        """Take what is wanted of the snapshot, at once."""


class Recorder(Protocol):
    """A log: is told of every tick, and never waits in it."""

    def begin(self, controller: Controller, plant: Plant) -> None:
        """A run is about to begin; this may take its time."""

    def record(self, tick: Tick, controller: Controller) -> None:
        """Keep what is wanted of a tick, at once."""

    def end(self, report: Report) -> None:
        """The run is over; this may take its time."""

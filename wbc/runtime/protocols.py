"""The protocols of a run's parts: controllers, plants, estimators and observers."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np

from wbc.command import Command
from wbc.estimation import Estimate
from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.runtime.report import Report
from wbc.runtime.schema import Quantity
from wbc.runtime.stream import TickStream
from wbc.runtime.tick import Tick
from wbc.state import State
from wbc.telemetry import ContactPlan, Telemetry


class Controller(Protocol):
    """A controller, which computes commands from estimates.

    One that is also a `TelemetrySource` is shown, logged and reported with its telemetry.
    """

    def reset(self, state: State) -> None:
        """Start anew from a state."""

    def step(self, estimate: Estimate) -> Command:
        """Return the command of one tick."""


@runtime_checkable
class VelocityController(Controller, Protocol):
    """A controller of a robot that walks where it is told, e.g. a `Walker`.

    Attributes:
        velocity: wanted velocity in the heading frame, forward, left (m/s) and turn to the left
            (rad/s); zero means to stand. Set at any tick.
    """

    velocity: tuple[float, float, float]

    @property
    def gait_cycle(self) -> float:
        """Duration of a step of each foot, s; any period for a controller without a gait."""


class ControllerFactory(Protocol):
    """Makes a new controller for a robot, in any process."""

    def __call__(self, robot: Robot, dt: float) -> VelocityController:
        """Return a controller.

        It is reset before its first tick. If it can be pickled, a run with it is forked from its
        state; else the run is repeated. If it is `Closeable`, it is closed at the end.

        Args:
            robot: the robot, as the controller knows it.
            dt: control period, s.
        """


@runtime_checkable
class TelemetrySource(Protocol):
    """A controller that provides telemetry and a contact plan."""

    @property
    def telemetry(self) -> Telemetry:
        """The telemetry of the last tick; read once per tick."""

    @property
    def contact_plan(self) -> ContactPlan:
        """The present support and the planned footsteps; read 30 times per second."""


class Plant(Protocol):
    """A plant, which can be measured and commanded.

    A plant may also be a `GroundTruthSource` or a `StoppablePlant`, or have a backlash
    (`HasBacklash`).
    """

    robot: Robot
    dt: float

    @property
    def time(self) -> float:
        """Time since the last reset, s."""

    def measure(self) -> Measurement:
        """Return the sensor readings now."""

    def step(self, command: Command) -> None:
        """Hold a command for one control period."""


@runtime_checkable
class GroundTruthSource(Protocol):
    """A plant that knows the true state.

    Falls, distances and joint limits are then judged by it instead of by the estimate. The
    estimator never sees it.
    """

    def ground_truth(self) -> State:
        """Return the true state now."""


@runtime_checkable
class StoppablePlant(Protocol):
    """A plant that must not go on with the last command when the run is over."""

    def stop(self) -> None:
        """Bring the robot into a safe state at once, because no command follows.

        Called right after the last tick, however the run ends; a second time does nothing.
        """


@runtime_checkable
class HasBacklash(Protocol):
    """A plant whose joints are known to have play; the default estimator counts with it.

    Attributes:
        backlash: play between the motors, where the encoders are, and the joints, rad.
    """

    backlash: float


@runtime_checkable
class HasPeriod(Protocol):
    """A controller or estimator that is made for one control period.

    Attributes:
        dt: control period, s.
    """

    dt: float


class StateEstimator(Protocol):
    """Turns measurements into estimates of state, contacts and foot loads."""

    def reset(self, state: State) -> None:
        """Start anew at a known state."""

    def update(
        self, measurement: Measurement, *, acceleration: np.ndarray | None = None
    ) -> Estimate:
        """Return the estimate now.

        Args:
            measurement: measurement of this tick.
            acceleration: (nv,) what the last command was to bring about, m/s² and rad/s².
        """


class Observer(Protocol):
    """Sees every tick of a run in the loop's process, after its command; it must never wait."""

    def begin(self, controller: Controller, plant: Plant) -> None:
        """Prepare for a run that is about to begin; this may block."""

    def observe(self, tick: Tick) -> None:
        """Process a tick, without waiting."""

    def end(self, report: Report) -> None:
        """Finish after the end of the run; this may block."""


@runtime_checkable
class StreamObserver(Protocol):
    """An `Observer` with a process of its own, which reads the ticks from shared memory.

    All stream observers of a run read the same stream.
    """

    stream: TickStream | None

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Quantities that it needs beside those of `wbc.runtime.quantities`."""

    def attach(self, stream: TickStream) -> None:
        """Read from this stream from now on; called before `begin`."""

"""One tick of a run, as observers in the loop's process see it."""

from __future__ import annotations

from dataclasses import dataclass

from wbc.command import Command
from wbc.estimation import Estimate
from wbc.measurement import Measurement
from wbc.state import State
from wbc.telemetry import ContactPlan, Telemetry

NO_TELEMETRY = Telemetry()


# Not frozen: that would triple the time to make one, 3 µs of every tick.
@dataclass(slots=True, eq=False)
class Tick:
    """What went in, what came out and how long it took.

    All observers get the same tick, which refers to arrays of others: change nothing, and copy what
    you keep.

    Attributes:
        time: plant time of the measurement, s. A time before the previous tick's begins a new run.
        measurement: sensor readings.
        estimate: state, contacts and foot loads, estimated from the measurement.
        command: what the controller made of the estimate.
        truth: the true state at that time, if the plant tells it.
        estimator_time: time that the estimator took, s.
        controller_time: time that the controller took, s.
        telemetry: what the controller tells; unknown values for a controller that tells nothing.
        contact_plan: the controller's contact plan, 30 times per second; None at other ticks.
        index: number of the tick in its run, from 0.
        run: number of the run, from 1.
        wall_time: when the tick ended, s since 1970.
        period: wall time since the end of the tick before, s.
    """

    time: float
    measurement: Measurement
    estimate: Estimate
    command: Command
    truth: State | None
    estimator_time: float
    controller_time: float
    telemetry: Telemetry = NO_TELEMETRY
    contact_plan: ContactPlan | None = None
    index: int = 0
    run: int = 1
    wall_time: float = 0.0
    period: float = 0.0

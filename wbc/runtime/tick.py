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
    """Inputs, outputs and computation times of one tick.

    All observers get the same tick, which refers to arrays of others: change nothing, and copy what
    you keep.

    Attributes:
        time: plant time of the measurement, s. A time before the previous tick's begins a new run.
        measurement: sensor readings.
        estimate: state, contacts and foot loads, estimated from the measurement.
        command: command that the controller computed from the estimate.
        truth: true state at that time, if the plant knows it.
        estimator_time: time that the estimator took, s.
        controller_time: time that the controller took, s.
        telemetry: telemetry of the controller; unknown values if it has none.
        contact_plan: the controller's contact plan, 30 times per second; None at other ticks.
        index: number of the tick in its run, from 0.
        run: number of the run, from 1.
        wall_time: time at which the tick ended, s since 1970.
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

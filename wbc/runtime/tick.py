"""One tick of a run, as an observer of every tick gets to see it."""

from __future__ import annotations

from dataclasses import dataclass

from wbc.command import Command
from wbc.estimation import Estimate
from wbc.measurement import Measurement
from wbc.state import State


@dataclass(frozen=True, slots=True)
class Tick:
    """What went in, what came out and how long it took.

    It keeps references: whoever wants to keep something copies it.

    Attributes:
        time: of the plant when it was measured, s. A time before the previous tick's begins
            a new run.
        measurement: sensor readings.
        estimate: state, contacts and foot loads, estimated from them.
        command: what the controller made of the estimate.
        truth: the state at that time, if the plant tells it.
        estimator_time: that the estimator took, s.
        controller_time: that the controller took, s.
    """

    time: float
    measurement: Measurement
    estimate: Estimate
    command: Command
    truth: State | None
    estimator_time: float
    controller_time: float

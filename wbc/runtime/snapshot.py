"""One instant of a run, as an observer gets to see it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from wbc.command import Status
from wbc.runtime.tick import Tick
from wbc.telemetry import Telemetry


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What a viewer draws. It keeps references: whoever shows it copies.

    Attributes:
        time: s. A time before the previous snapshot's begins a new run.
        q: (nq,) configuration, Pinocchio's convention; m, unit quaternion, rad.
        wrenches: sole or contact name -> (6,) force then moment that the ground
            exerts on the robot, at the contact's centre, in contact axes; N, N·m.
            A name must be that of a frame of the model.
        telemetry: balance and gait quantities, world axes.
        status: how the tick's QP ended.
        text: one short line for the eyes, at most 240 bytes.
    """

    time: float
    q: np.ndarray
    wrenches: Mapping[str, np.ndarray] = field(default_factory=dict)
    telemetry: Telemetry = field(default_factory=Telemetry)
    status: Status = Status.OK
    text: str = ""

    @staticmethod
    def of(tick: Tick, controller: object, text: str = "") -> Snapshot:
        """The instant of a tick, with what its controller tells about itself.

        Args:
            tick: just done.
            controller: that did it; it may have `telemetry`, which is made when it is asked for.
            text: unless the command has to explain itself.
        """
        command = tick.command
        telemetry = getattr(controller, "telemetry", None)
        return Snapshot(
            tick.time,
            tick.estimate.state.q,
            tick.measurement.foot_wrenches or command.wrenches,
            _UNKNOWN if telemetry is None else telemetry,
            command.status,
            command.explanation or text,
        )


_UNKNOWN = Telemetry()

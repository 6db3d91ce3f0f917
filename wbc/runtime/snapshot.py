"""What a viewer draws of one instant of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from wbc.command import Status
from wbc.runtime.quantities import STATUSES
from wbc.runtime.record import TickRecord
from wbc.runtime.stream import TickStream
from wbc.runtime.tick import Tick
from wbc.telemetry import PHASES, ContactPlan, Telemetry


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What a viewer draws of one instant of a run.

    It refers to arrays of others: copy what you keep.

    Attributes:
        time: s. A time before the previous snapshot's begins a new run.
        q: (nq,) configuration, Pinocchio's convention; m, unit quaternion, rad.
        wrenches: sole or contact name -> (6,) force then moment that the ground exerts on the
            robot, at the contact's centre, in contact axes; N, N·m. A name must be that of a
            frame of the model.
        telemetry: balance quantities, world axes.
        contact_plan: support polygon, footsteps and swing path, world axes.
        status: how the tick's QP ended.
        text: one short line, at most 240 bytes.
    """

    time: float
    q: np.ndarray
    wrenches: Mapping[str, np.ndarray] = field(default_factory=dict)
    telemetry: Telemetry = field(default_factory=Telemetry)
    contact_plan: ContactPlan = field(default_factory=ContactPlan)
    status: Status = Status.OK
    text: str = ""

    @staticmethod
    def of_tick(tick: Tick, contact_plan: ContactPlan) -> Snapshot:
        """Return the snapshot of a tick.

        Args:
            tick: just done.
            contact_plan: the latest.
        """
        command = tick.command
        return Snapshot(
            tick.time,
            tick.estimate.state.q,
            tick.measurement.foot_wrenches or command.wrenches,
            tick.telemetry,
            contact_plan,
            command.status,
            command.explanation or tick.telemetry.status_text,
        )

    def write(self, stream: TickStream) -> None:
        """Write the snapshot as a record of a stream.

        Raises:
            SchemaError: a part has the wrong size.
        """
        telemetry = self.telemetry
        values = {
            "time": self.time,
            "q": self.q,
            "status": STATUSES.index(self.status),
            "phase": PHASES.index(telemetry.phase) if telemetry.phase in PHASES else 0,
            "com": telemetry.com,
            "dcm": telemetry.dcm,
            "dcm_reference": telemetry.dcm_reference,
            "zmp": telemetry.zmp,
        }
        stream.write_values(values, self.wrenches, self.contact_plan, self.text)

    @staticmethod
    def of_record(record: TickRecord) -> Snapshot:
        """Return the snapshot of a tick's record."""
        return Snapshot(
            record.time,
            record["q"],
            record.foot_wrenches or record.commanded_wrenches,
            record.telemetry,
            record.contact_plan,
            record.status,
            record.text,
        )

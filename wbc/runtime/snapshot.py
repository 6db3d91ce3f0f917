"""The content of one instant of a run that a viewer draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wbc.command import Command, Status
from wbc.estimation import Estimate
from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.runtime.quantities import STATUSES
from wbc.runtime.record import contact_plan_of, contact_wrenches_of, text_of
from wbc.runtime.tick import Tick
from wbc.state import State
from wbc.telemetry import PHASES, ContactPlan, Telemetry

_FOOT_WRENCH = "foot_wrench/"


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The content of one instant of a run that a viewer draws.

    It refers to arrays of others: copy what you keep.

    Attributes:
        time: s. A time before the previous snapshot's begins a new run.
        q: (nq,) configuration, Pinocchio's convention; m, unit quaternion, rad.
        wrenches: sole or contact name -> (6,) force then moment that the ground exerts on the
            robot, at the contact's centre, in contact axes; N, N·m. A name must be that of a
            frame of the model.
        telemetry: CoM, DCM, its reference and ZMP, world axes, and the gait phase.
        contact_plan: support polygon, footsteps and swing path, world axes.
        status: status of the tick's QP.
        text: one short line, at most 240 bytes.
        run: number of the run; another than the previous snapshot's begins a new run, too.
    """

    time: float
    q: np.ndarray
    wrenches: Mapping[str, np.ndarray] = field(default_factory=dict)
    telemetry: Telemetry = field(default_factory=Telemetry)
    contact_plan: ContactPlan = field(default_factory=ContactPlan)
    status: Status = Status.OK
    text: str = ""
    run: int = 1

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
            tick.run,
        )

    def to_tick(self, robot: Robot) -> Tick:
        """Return a tick with the content of the snapshot; all else is NaN."""
        joints, axes, dofs = (np.full(n, np.nan) for n in (robot.na, 3, robot.nv))
        return Tick(
            time=self.time,
            measurement=Measurement(self.time, joints, joints, axes, axes),
            estimate=Estimate(State(self.q, dofs)),
            command=Command(
                joints, dofs, dict(self.wrenches), joints, joints, self.status, self.text
            ),
            truth=None,
            estimator_time=np.nan,
            controller_time=np.nan,
            telemetry=self.telemetry,
            contact_plan=self.contact_plan,
            run=self.run,
        )

    @staticmethod
    def of_record(record: Any) -> Snapshot:
        """Return the snapshot of a record of `wbc.runtime.stream.TickReader`."""
        measured = {
            name.removeprefix(_FOOT_WRENCH): record[name]
            for name in record.dtype.names
            if name.startswith(_FOOT_WRENCH) and np.isfinite(record[name]).all()
        }
        return Snapshot(
            float(record["time"]),
            record["q"],
            measured or contact_wrenches_of(record),
            Telemetry(
                com=record["com"],
                dcm=record["dcm"],
                dcm_reference=record["dcm_reference"],
                zmp=record["zmp"],
                phase=PHASES[int(record["phase"])],
            ),
            contact_plan_of(record),
            STATUSES[int(record["status"])],
            text_of(record),
            int(record["run"]),
        )

"""A tick's record with the names and types of what it holds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wbc.command import Status
from wbc.runtime.quantities import STATUSES
from wbc.runtime.schema import Schema
from wbc.telemetry import PHASES, ContactPlan, Footstep, Telemetry

_SIDES = ("left", "right")


class TickRecord:
    """One record of a `TickStream`, see `wbc.runtime.quantities` for its columns.

    Args:
        schema: of the record.
        record: of `schema.dtype`.
        contact_names: by the numbers in records.
    """

    def __init__(self, schema: Schema, record: Any, contact_names: Sequence[str]) -> None:
        self.schema, self._record, self._names = schema, record, contact_names

    def __getitem__(self, name: str) -> Any:
        """Return a column's number, or its array, (size,).

        Raises:
            SchemaError: there is no such column.
        """
        self.schema.column(name)
        return self._record[name]

    @property
    def time(self) -> float:
        """Plant time, s."""
        return float(self._record["time"])

    @property
    def status(self) -> Status:
        """How the tick's QP ended."""
        return STATUSES[int(self._record["status"])]

    @property
    def text(self) -> str:
        """The explanation of a failed solve, else the controller's status text."""
        data: bytes = self._record["text"]
        return data.decode("utf-8", "ignore")

    @property
    def commanded_wrenches(self) -> dict[str, np.ndarray]:
        """Contact name -> (6,) commanded wrench in contact axes, N, N·m."""
        rows = known_rows(self._record["contacts"])
        return {self._names[int(row[0])]: row[1:] for row in rows if row[0] >= 0.0}

    @property
    def foot_wrenches(self) -> dict[str, np.ndarray]:
        """Sole name -> (6,) measured wrench in sole axes, N, N·m; empty without foot sensors."""
        prefix = "foot_wrench/"
        found = {
            c.name[len(prefix) :]: self._record[c.name]
            for c in self.schema.columns
            if c.name.startswith(prefix)
        }
        return {name: wrench for name, wrench in found.items() if np.isfinite(wrench).all()}

    @property
    def telemetry(self) -> Telemetry:
        """What the controller tells, but for its status text, which is in `text`."""
        record = self._record
        return Telemetry(
            com=record["com"],
            dcm=record["dcm"],
            dcm_reference=record["dcm_reference"],
            zmp=record["zmp"],
            velocity=record["velocity_command"],
            heading=float(record["heading"]),
            dcm_error=float(record["dcm_error"]),
            phase=PHASES[int(record["phase"])],
            steps=int(np.nan_to_num(record["steps"])),
        )

    @property
    def contact_plan(self) -> ContactPlan:
        """The latest contact plan."""
        return contact_plan_of(self._record)


def contact_plan_of(record: Any) -> ContactPlan:
    """Return the contact plan in a record."""
    steps = known_rows(record["footsteps"])
    return ContactPlan(
        support=known_rows(record["support"]),
        footsteps=tuple(Footstep(_SIDES[int(row[0])], row[1:4], float(row[4])) for row in steps),
        swing_path=known_rows(record["swing_path"]),
    )


def known_rows(rows: np.ndarray) -> np.ndarray:
    """Return the rows that are used, of an array whose unused rows are NaN."""
    known: np.ndarray = rows[~np.isnan(rows[:, 0])]
    return known

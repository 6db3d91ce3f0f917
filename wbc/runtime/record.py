"""The fields of a record whose length varies: contact wrenches, contact plan and text.

Each has a fixed number of rows; unused rows are NaN, and what exceeds them is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from wbc.telemetry import SIDES, ContactPlan, Footstep

CONTACTS, SUPPORT, FOOTSTEPS, SWING = 8, 16, 16, 32  # rows
_NAME, TEXT = 64, 240  # bytes, multiples of 8
VARYING_FIELDS: tuple[tuple[str, str, tuple[int, ...]], ...] = (
    ("contact_names", f"S{_NAME}", (CONTACTS,)),
    ("contact_wrenches", "f8", (CONTACTS, 6)),
    ("contact_plan_tick", "f8", ()),  # the tick of the run at which the plan was computed
    ("support", "f8", (SUPPORT, 3)),
    ("footsteps", "f8", (FOOTSTEPS, 5)),  # index in SIDES, x, y, z, yaw
    ("swing_path", "f8", (SWING, 3)),
    ("text", f"S{TEXT}", ()),
)


class VaryingFieldsWriter:
    """Writes the fields of a record whose length varies, each only when it has changed.

    Args:
        record: structured array of one record, (1,).
    """

    def __init__(self, record: np.ndarray) -> None:
        self._record = record
        self._contacts: tuple[str, ...] | None = None
        self._wrenches = tuple(record["contact_wrenches"][0])
        self._support, self._footsteps = record["support"][0], record["footsteps"][0]
        self._swing_path = record["swing_path"][0]
        self._text: str | None = None
        self.set_wrenches({})
        self.set_text("")

    def set_wrenches(self, wrenches: Mapping[str, np.ndarray]) -> None:
        """Write contact wrenches, (6,), by the names of the contacts."""
        names = tuple(wrenches)
        if names != self._contacts:
            self._contacts = names
            self._record["contact_wrenches"] = np.nan
            stored = [name.encode("utf-8", "replace") for name in names[:CONTACTS]]
            self._record["contact_names"] = stored + [b""] * (CONTACTS - len(stored))
        for row, wrench in zip(self._wrenches, wrenches.values(), strict=False):
            row[:] = wrench

    def set_contact_plan(self, plan: ContactPlan, tick: float) -> None:
        """Write the contact plan that was computed at a tick."""
        path = plan.swing_path
        if len(path) > SWING:
            path = path[np.linspace(0, len(path) - 1, SWING).round().astype(int)]
        self._record["contact_plan_tick"] = tick
        _set_rows(self._support, plan.support[:SUPPORT])
        _set_rows(self._swing_path, path)
        self._footsteps[:] = np.nan
        for row, step in zip(self._footsteps, plan.footsteps, strict=False):
            row[0], row[1:4], row[4] = SIDES.index(step.side), step.position, step.yaw

    def set_text(self, text: str) -> None:
        """Write a text."""
        if text is not self._text:
            self._text = text
            self._record["text"] = text.encode("utf-8", "replace")[:TEXT]


def _set_rows(rows: np.ndarray, values: np.ndarray) -> None:
    rows[: len(values)] = values
    rows[len(values) :] = np.nan


def contact_names(records: np.ndarray) -> set[str]:
    """Return the names of all contacts that have wrenches in records, (n,)."""
    names = set(np.unique(records["contact_names"]).tolist()) - {b""}
    return {name.decode("utf-8", "ignore") for name in names}


def contact_wrenches_of(record: Any) -> dict[str, np.ndarray]:
    """Return contact name -> (6,) commanded wrench in contact axes, N, N·m."""
    names = (name.decode("utf-8", "ignore") for name in record["contact_names"].tolist())
    return {name: w for name, w in zip(names, record["contact_wrenches"], strict=True) if name}


def contact_plan_of(record: Any) -> ContactPlan:
    """Return the contact plan in a record."""
    steps = used_rows(record["footsteps"])
    return ContactPlan(
        support=used_rows(record["support"]),
        footsteps=tuple(Footstep(SIDES[int(row[0])], row[1:4], float(row[4])) for row in steps),
        swing_path=used_rows(record["swing_path"]),
    )


def text_of(record: Any) -> str:
    """Return the explanation of a failed solve in a record, else the controller's status text."""
    data: bytes = record["text"]
    return data.decode("utf-8", "ignore")


def used_rows(rows: np.ndarray) -> np.ndarray:
    """Return the rows of a varying field that are used."""
    used: np.ndarray = rows[~np.isnan(rows[:, 0])]
    return used

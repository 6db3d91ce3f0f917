"""Names and units of the rows of a QP, for explanations."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RowBlock:
    """Consecutive rows that belong to one task, contact or limit.

    Attributes:
        name: the owner, e.g. "torque limit" or "right_sole cone".
        unit: unit of the rows' values, e.g. "N·m"; or two of them, "m/s², rad/s²".
        start: first row.
        stop: one past the last row.
        labels: one text per row ("leg_left_4_joint"), or empty.
        switch: when there are two units, how many rows have the first.
    """

    name: str
    unit: str
    start: int
    stop: int
    labels: tuple[str, ...] = ()
    switch: int = 3

    def label(self, row: int) -> str:
        """Return the text for a row, by its index in the whole problem."""
        k = row - self.start
        return f"{self.name} [{self.labels[k]}]" if self.labels else f"{self.name} [{k}]"

    def unit_of(self, row: int) -> str:
        """Return the unit of a row, by its index in the whole problem."""
        units = self.unit.split(", ")
        return units[0] if row - self.start < self.switch else units[-1]

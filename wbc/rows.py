"""Named rows: what tasks, contacts and limits hand to the QP."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RowBlock:
    """A run of consecutive rows that belong to one thing.

    Attributes:
        name: whose rows they are, e.g. "torque limit" or "right_sole cone".
        unit: unit of the rows' values, e.g. "N·m".
        start: first row.
        stop: one past the last row.
        labels: one text per row ("leg_left_4_joint"), or empty.
    """

    name: str
    unit: str
    start: int
    stop: int
    labels: tuple[str, ...] = ()

    def label(self, row: int) -> str:
        """Text for a row by its index in the whole problem."""
        k = row - self.start
        return f"{self.name} [{self.labels[k]}]" if self.labels else f"{self.name} [{k}]"

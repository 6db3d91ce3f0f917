"""A tick with the stamp of the messages that are made from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.runtime.mode import Mode
from wbc.telemetry import PHASES


@dataclass(frozen=True, slots=True)
class StampedTick:
    """The record of a tick with the stamp of its messages.

    Attributes:
        stamp: stamp of the messages, s.
        time: plant time, s.
        run: number of the run; it grows with each reset.
        mode: mode of the loop.
        record: structured array of one record, (1,), see `wbc.runtime.quantities`.
    """

    stamp: float
    time: float
    run: int
    mode: Mode
    record: np.ndarray

    @staticmethod
    def from_record(record: np.ndarray) -> StampedTick:
        """Return the tick of a record, (1,), stamped with the wall time at which the tick ended."""
        row = record[0]
        mode = Mode(int(row["mode"]))
        return StampedTick(
            float(row["wall_time"]), float(row["time"]), int(row["run"]), mode, record
        )

    def __getitem__(self, name: str) -> Any:
        """Return the number or array of a column."""
        return self.record[0][name]

    @property
    def phase(self) -> str:
        """Gait phase."""
        return PHASES[int(self["phase"])]

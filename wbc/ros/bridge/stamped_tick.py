"""A tick as the robot's node sees it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.runtime.mode import Mode
from wbc.telemetry import PHASES


@dataclass(frozen=True, slots=True)
class StampedTick:
    """A tick's record with the stamp of its messages.

    Attributes:
        stamp: of the messages, s.
        time: plant time, s.
        run: number of the run; it grows with each reset.
        mode: of the loop.
        record: structured array of one record, (1,), see `wbc.runtime.quantities`.
    """

    stamp: float
    time: float
    run: int
    mode: Mode
    record: np.ndarray

    @staticmethod
    def of(record: np.ndarray) -> StampedTick:
        """Return a record, (1,), with the wall time at which its tick ended as its stamp."""
        one = record[0]
        mode = Mode(int(one["mode"]))
        return StampedTick(
            float(one["wall_time"]), float(one["time"]), int(one["run"]), mode, record
        )

    def __getitem__(self, name: str) -> Any:
        """Return a column's number or array."""
        return self.record[0][name]

    @property
    def phase(self) -> str:
        """Gait phase."""
        return PHASES[int(self["phase"])]

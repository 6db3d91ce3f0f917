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
    def from_records(records: np.ndarray) -> list[StampedTick]:
        """Return the ticks of records, (n,), stamped with the wall time at which each ended."""
        names = ("wall_time", "time", "run", "mode")
        columns = zip(*(records[name].tolist() for name in names), strict=True)
        return [
            StampedTick(stamp, time, int(run), Mode(int(mode)), records[k : k + 1])
            for k, (stamp, time, run, mode) in enumerate(columns)
        ]

    def __getitem__(self, name: str) -> Any:
        """Return the number or array of a column."""
        return self.record[0][name]

    @property
    def phase(self) -> str:
        """Gait phase."""
        return PHASES[int(self["phase"])]

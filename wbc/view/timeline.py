"""The timeline of a completed run, which can be shown at any time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from wbc.runtime.snapshot import Snapshot
from wbc.view.recording import Recording

_STEP = 1.0 / 15.0  # s, period at which the history of a scene is rebuilt


class Timeline(Protocol):
    """Snapshots by time."""

    @property
    def start(self) -> float:
        """Time of the first snapshot, s."""

    @property
    def end(self) -> float:
        """Time of the last snapshot, s."""

    def at(self, time: float) -> Snapshot:
        """Return the last snapshot at or before a time (s), or the first one for earlier times."""


@dataclass(frozen=True, eq=False)
class TimeSeries:
    """A quantity over the duration of a run.

    Attributes:
        label: Name and unit of the quantity.
        time: Times, s, shape (n,).
        values: Values, shape (n,); NaN where unknown.
    """

    label: str
    time: np.ndarray
    values: np.ndarray


def record(
    timeline: Timeline,
    recording: Recording,
    progress: Callable[[float], None] = lambda share: None,
) -> None:
    """Record a whole timeline at the recording's frame rate.

    Args:
        timeline: Run to record.
        recording: Recording to add the frames to.
        progress: Called with the share that has been recorded, 0 to 1.
    """
    steps = max(round((timeline.end - timeline.start) * recording.rate), 1)
    for k, time in enumerate(np.linspace(timeline.start, timeline.end, steps + 1)):
        recording.show(timeline.at(float(time)))
        progress(k / steps)


def up_to(timeline: Timeline, time: float, last: float | None, memory: float) -> Iterator[Snapshot]:
    """Yield the snapshots that update a scene to a time, including its history.

    Args:
        timeline: Run to show.
        time: Time to show, s.
        last: Time of the snapshot that the scene shows, s; None if it shows none.
        memory: Duration of the scene's history, s.
    """
    time = min(max(time, timeline.start), timeline.end)
    begin = max(time - memory, timeline.start)
    if last is not None and last <= time:
        begin = max(begin, last)
    steps = int((time - begin) / _STEP)
    for k in range(steps, 0, -1):
        yield timeline.at(time - k * _STEP)
    yield timeline.at(time)


def thinned(series: Sequence[TimeSeries], points: int) -> list[TimeSeries]:
    """Return the series with at most `points` points each, the largest value of each group."""
    thin = []
    for one in series:
        starts = np.arange(0, len(one.time), -(-len(one.time) // points) or 1)
        known = np.where(np.isfinite(one.values), one.values, -np.inf)
        peaks = np.maximum.reduceat(known, starts) if len(starts) else known
        thin.append(TimeSeries(one.label, one.time[starts], peaks))
    return thin

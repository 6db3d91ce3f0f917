"""The timeline of a run that is over, to be shown at any of its times."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from wbc.runtime.snapshot import Snapshot
from wbc.view.recording import Recording

_STEP = 1.0 / 15.0  # s: what has a history is told of it in steps of this


class Timeline(Protocol):
    """Snapshots by time.

    Attributes:
        start: time of the first snapshot, s.
        end: time of the last snapshot, s.
    """

    @property
    def start(self) -> float:
        """Time of the first snapshot, s."""

    @property
    def end(self) -> float:
        """Time of the last snapshot, s."""

    def at(self, time: float) -> Snapshot:
        """The last snapshot that is not after a time, s; the first one for earlier times."""


@dataclass(frozen=True, eq=False)
class TimeSeries:
    """A quantity over the whole time of a run.

    Attributes:
        label: what it is, with its unit.
        time: (n,) s.
        values: (n,) NaN where it is not known.
    """

    label: str
    time: np.ndarray
    values: np.ndarray


def record(timeline: Timeline, recording: Recording) -> None:
    """Record a whole timeline, at the recording's rate."""
    steps = max(round((timeline.end - timeline.start) * recording.rate), 1)
    for time in np.linspace(timeline.start, timeline.end, steps + 1):
        recording.show(timeline.at(float(time)))


def up_to(timeline: Timeline, time: float, last: float | None, memory: float) -> Iterator[Snapshot]:
    """The snapshots that bring a scene to a time, history included.

    Args:
        timeline: what is shown.
        time: where to, s.
        last: time of the snapshot that the scene was shown last, s; None: none.
        memory: how far the scene's history goes back, s.
    """
    time = min(max(time, timeline.start), timeline.end)
    begin = max(time - memory, timeline.start)
    if last is not None and last <= time:
        begin = max(begin, last)
    steps = int((time - begin) / _STEP)
    for k in range(steps, 0, -1):
        yield timeline.at(time - k * _STEP)
    yield timeline.at(time)


def thinned(
    series: Sequence[TimeSeries], points: int, pick: Callable[..., np.ndarray]
) -> list[TimeSeries]:
    """Strips with at most so many points, each picked from those that it stands for."""
    thin: list[TimeSeries] = []
    for one in series:
        width = -(-len(one.time) // points)
        starts = np.arange(0, len(one.time), max(width, 1))
        thin.append(TimeSeries(one.label, one.time[starts], pick(one.values, starts)))
    return thin

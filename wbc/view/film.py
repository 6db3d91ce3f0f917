"""A run that is over, to be shown at any of its times."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from wbc.runtime.snapshot import Snapshot
from wbc.view.recording import Recording

_STEP = 1.0 / 15.0  # s: what has a history is told of it in steps of this


class Film(Protocol):
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
class Strip:
    """A quantity over the whole time of a film, to find one's way by.

    Attributes:
        label: what it is, with its unit.
        time: (n,) s.
        values: (n,) NaN where it is not known.
    """

    label: str
    time: np.ndarray
    values: np.ndarray


def record(film: Film, recording: Recording) -> None:
    """Put a whole film into a recording, at the recording's rate."""
    steps = max(round((film.end - film.start) * recording.rate), 1)
    for time in np.linspace(film.start, film.end, steps + 1):
        recording.show(film.at(float(time)))


def up_to(film: Film, time: float, last: float | None, memory: float) -> Iterator[Snapshot]:
    """The snapshots that bring a scene to a time, history included.

    Args:
        film: what is shown.
        time: where to, s.
        last: time of the snapshot that the scene was shown last, s; None: none.
        memory: how far the scene's history goes back, s.
    """
    time = min(max(time, film.start), film.end)
    begin = max(time - memory, film.start)
    if last is not None and last <= time:
        begin = max(begin, last)
    steps = int((time - begin) / _STEP)
    for k in range(steps, 0, -1):
        yield film.at(time - k * _STEP)
    yield film.at(time)


def thinned(strips: Sequence[Strip], points: int, pick: Callable[..., np.ndarray]) -> list[Strip]:
    """Strips with at most so many points, each picked from those that it stands for."""
    thin = []
    for strip in strips:
        width = -(-len(strip.time) // points)
        starts = np.arange(0, len(strip.time), max(width, 1))
        thin.append(Strip(strip.label, strip.time[starts], pick(strip.values, starts)))
    return thin

"""`LoggedTimeline`: a long log to be played, of which only the shown parts are in memory."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from wbc.log.reader import Log
from wbc.log.run import LoggedRun
from wbc.log.time_span import TimeSpan
from wbc.runtime.event import RESET
from wbc.runtime.snapshot import Snapshot

_STATE, _EVENTS = "/controller_state", "/events"
_TOPICS = {
    *(_STATE, _EVENTS, "/odom", "/joint_states", "/support_polygon", "/footsteps", "/swing_path"),
    *("/balance/com", "/balance/dcm", "/balance/dcm_reference", "/balance/zmp"),
}
_PREFIXES = ("/sensors/wrench/", "/command/wrench/")
_PART = 4.0  # s
_MOST_PARTS = 4  # in memory: the history that a scene shows
_BEFORE = 1.6  # s before a part, from which its contact plan may come


class _ShownTopics:
    """The topics that a snapshot is made of."""

    def __contains__(self, topic: object) -> bool:
        return topic in _TOPICS or str(topic).startswith(_PREFIXES)


class LoggedTimeline:
    """The snapshots of a log by time; see `wbc.view.timeline.Timeline`.

    Args:
        path: Path of the log.
        progress: Called with the share of the file that has been read, 0 to 1.

    Attributes:
        overview: The run, with states of the controller and events only.

    Raises:
        LogError: See `Log` and `LoggedRun`.
        MissingExtra: `mcap` or `rosbags` is not installed.
    """

    def __init__(
        self, path: str | Path, progress: Callable[[float], None] = lambda share: None
    ) -> None:
        self.overview = LoggedRun(Log(path, topics=(_STATE, _EVENTS), progress=progress))
        self._resets = np.array([e.time for e in self.overview.events if e.kind == RESET])
        self._parts: OrderedDict[int, LoggedRun] = OrderedDict()

    @property
    def start(self) -> float:
        """Time of the first tick, s."""
        return self.overview.start

    @property
    def end(self) -> float:
        """Time of the last tick, s."""
        return self.overview.end

    def at(self, time: float) -> Snapshot:
        """Return the snapshot of the last tick at or before a time (s), or of the first tick."""
        tick = np.searchsorted(self.overview.time, time + 1e-9, "right") - 1
        time = float(self.overview.time[max(int(tick), 0)])
        run = 1 + int(np.searchsorted(self._resets, time + 1e-9, "right"))
        return replace(self._part(math.floor((time - self.start) / _PART)).at(time), run=run)

    def _part(self, number: int) -> LoggedRun:
        part = self._parts.pop(number, None)
        if part is None:
            begin = self.start + number * _PART
            span = TimeSpan(begin - _BEFORE, begin + _PART + 1e-3)
            part = LoggedRun(self.overview.log.between(span, _ShownTopics()))
        self._parts[number] = part
        while len(self._parts) > _MOST_PARTS:
            self._parts.popitem(last=False)
        return part

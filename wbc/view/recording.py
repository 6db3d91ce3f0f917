"""`Recording`: snapshots of a run as one HTML file that plays offline."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wbc.atomic_file import replacing
from wbc.closeable import Closeable
from wbc.errors import StateError
from wbc.runtime.event import FALL, RESET, RunEvent
from wbc.runtime.rate_limiter import RateLimiter
from wbc.runtime.snapshot import Snapshot
from wbc.telemetry import ContactPlan
from wbc.view.errors import ViewerError
from wbc.view.terrain import checked_boxes

if TYPE_CHECKING:
    from wbc.robot import Robot
    from wbc.runtime.protocols import Controller, Plant
    from wbc.runtime.report import Report
    from wbc.runtime.tick import Tick

_MOST_FRAMES = 20_000  # 11 minutes at 30 Hz, some 100 MB
_TOLERANCE = 1e-9  # s, for the rounding of times


@dataclass(frozen=True, slots=True)
class Marker:
    """A fall or a reset.

    Attributes:
        time: Time in the recording, s.
        kind: "fall" or "reset".
        text: Why the robot fell.
    """

    time: float
    kind: str
    text: str


class Recording(Closeable):
    """Collects snapshots during a run and writes the file afterwards.

    The file holds meshcat's viewer, the robot's meshes and all poses, and needs neither network nor
    server. It starts to play at once and repeats.

    Args:
        robot: Robot to show.
        path: Path that `close` (or leaving the `with` block) saves to.
        rate: Frame rate in plant time, Hz. It is halved whenever there are 20,000 frames.
        boxes: Terrain as boxes: see `wbc.sim.Terrain`.

    Attributes:
        boxes: Terrain as boxes.
        frames: Copies of the snapshots so far, those of all runs.
        times: Their times, s, which go on over resets.
        markers: Falls and resets.

    Raises:
        ViewerError: The rate is not positive, or the boxes are invalid.
    """

    def __init__(
        self,
        robot: Robot,
        path: str | Path | None = None,
        *,
        rate: float = 30.0,
        boxes: np.ndarray | None = None,
    ) -> None:
        if not rate > 0.0:
            raise ViewerError(f"rate is {rate} Hz; a recording needs a positive one")
        self.robot = robot
        self.rate = float(rate)
        self._path = Path(path) if path is not None else None
        self.boxes = checked_boxes(boxes)
        self.frames: list[Snapshot] = []
        self.times: list[float] = []
        self.markers: list[Marker] = []
        self._contact_plan = ContactPlan()
        self._limiter = RateLimiter(self.rate, _TOLERANCE)
        self._last = -np.inf  # plant time, s
        self._offset = 0.0  # s, of the present run

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.frames)

    def begin(self, controller: Controller, plant: Plant) -> None:
        """Do nothing; see `wbc.runtime.protocols.Observer`."""

    def observe(self, tick: Tick) -> None:
        """Copy the tick if the next frame is due."""
        if tick.contact_plan is not None:
            self._contact_plan = tick.contact_plan
        now = self._session_time(tick.time)
        if self._limiter.is_due(now):
            self._add(Snapshot.of_tick(tick, self._contact_plan), now)

    def on_event(self, event: RunEvent) -> None:
        """Note a fall or a reset; see `wbc.runtime.event.EventObserver`."""
        if event.kind in (FALL, RESET):
            self.markers.append(Marker(self._session_time(event.time), event.kind, event.reason))

    def end(self, report: Report) -> None:
        """Do nothing; see `wbc.runtime.protocols.Observer`."""

    def show(self, snapshot: Snapshot) -> None:
        """Copy the snapshot if the next frame is due.

        A time before the previous one begins a new run, which follows in the recording.

        Raises:
            StateError: `snapshot.q` has the wrong size.
        """
        now = self._session_time(float(snapshot.time))
        if self._limiter.is_due(now):
            self._add(snapshot, now)

    def _session_time(self, now: float) -> float:
        """Return a time of the plant, s, continued over resets."""
        if now < self._last:
            self._offset += self._last + 1.0 / self.rate - now
        self._last = now
        return now + self._offset

    def _add(self, snapshot: Snapshot, now: float) -> None:
        if np.shape(snapshot.q) != (self.robot.nq,):
            raise StateError(
                f"snapshot.q has shape {np.shape(snapshot.q)}, the model needs ({self.robot.nq},)"
            )
        self.frames.append(deepcopy(snapshot))
        self.times.append(now)
        if len(self.frames) >= _MOST_FRAMES:  # long sessions are kept whole, at a lower rate
            del self.frames[1::2], self.times[1::2]
            self.rate *= 0.5
            self._limiter.restart(self.rate)

    def save(self, path: str | Path) -> Path:
        """Write the file.

        Returns:
            The path of the file.

        Raises:
            ViewerError: nothing was recorded, or the file cannot be written.
        """
        path = Path(path)
        # Imported here so that a recorded run does not wait for the drawing modules.
        from wbc.view.recorded_page import recorded_page

        page = recorded_page(self)
        try:
            with replacing(path) as file:
                file.write_text(page, "utf-8")
        except OSError as error:
            raise ViewerError(
                f"cannot write the recording to {path}: {error.strerror}; give another path"
            ) from error
        return path

    def close(self) -> None:
        """Save to the constructor's path if there is one and the recording has a frame."""
        if self._path is not None and self.frames:
            self.save(self._path)

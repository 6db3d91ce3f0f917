"""`Recording`: snapshots of a run as one HTML file that plays offline."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wbc.closeable import Closeable
from wbc.errors import StateError
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

_TOLERANCE = 1e-9  # s, for the rounding of times


class Recording(Closeable):
    """Collects snapshots during a run and writes the file afterwards.

    The file holds meshcat's viewer, the robot's meshes and all poses, and needs neither network nor
    server. It starts to play at once and repeats.

    Args:
        robot: Robot to show.
        path: Path that `close` (or leaving the `with` block) saves to.
        rate: Frame rate in plant time, Hz.
        boxes: Terrain as boxes: see `wbc.sim.Terrain`.

    Attributes:
        frames: Copies of the snapshots so far.

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
        self._boxes = checked_boxes(boxes)
        self.frames: list[Snapshot] = []
        self._contact_plan = ContactPlan()
        self._limiter = RateLimiter(self.rate, _TOLERANCE)
        self._last = -np.inf

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.frames)

    def begin(self, controller: Controller, plant: Plant) -> None:
        """Do nothing; see `wbc.runtime.protocols.Observer`."""

    def observe(self, tick: Tick) -> None:
        """Copy the tick if the next frame is due."""
        if tick.contact_plan is not None:
            self._contact_plan = tick.contact_plan
        if self._is_due(tick.time):
            self._add(Snapshot.of_tick(tick, self._contact_plan))

    def end(self, report: Report) -> None:
        """Do nothing; see `wbc.runtime.protocols.Observer`."""

    def show(self, snapshot: Snapshot) -> None:
        """Copy the snapshot if the next frame is due.

        A time before the previous one begins a new run and restarts the recording.

        Raises:
            StateError: `snapshot.q` has the wrong size.
        """
        if self._is_due(float(snapshot.time)):
            self._add(snapshot)

    def _is_due(self, now: float) -> bool:
        if now < self._last:
            self.frames.clear()
            self._limiter.restart(self.rate)
        self._last = now
        return self._limiter.is_due(now)

    def _add(self, snapshot: Snapshot) -> None:
        if np.shape(snapshot.q) != (self.robot.nq,):
            raise StateError(
                f"snapshot.q has shape {np.shape(snapshot.q)}, the model needs ({self.robot.nq},)"
            )
        self.frames.append(deepcopy(snapshot))

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

        page = recorded_page(self.robot, self._boxes, self.frames)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(page, "utf-8")
        except OSError as error:
            raise ViewerError(
                f"cannot write the recording to {path}: {error.strerror}; give another path"
            ) from error
        return path

    def close(self) -> None:
        """Save to the constructor's path if there is one and the recording has a frame."""
        if self._path is not None and self.frames:
            self.save(self._path)

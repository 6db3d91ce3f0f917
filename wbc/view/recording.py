"""`Recording`: snapshots of a run as one HTML file that plays offline."""

from __future__ import annotations

import base64
import struct
import zlib
from copy import deepcopy
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.closeable import Closeable
from wbc.errors import StateError
from wbc.runtime.snapshot import Snapshot
from wbc.telemetry import ContactPlan
from wbc.view.due import next_due
from wbc.view.errors import ViewerError
from wbc.view.terrain import checked_boxes

if TYPE_CHECKING:
    from wbc.robot import Robot
    from wbc.runtime.protocols import Controller, Plant
    from wbc.runtime.report import Report
    from wbc.runtime.tick import Tick
    from wbc.view.actors import SceneNode

_STILL = 1e-5  # m or 1; smaller changes of a pose are ignored
_DISCRETE, _LINEAR = 2300, 2301  # three.js's names of interpolations
#: Tolerance for rounding of times, s.
_GRACE = 1e-9
_GZIP = 16 + zlib.MAX_WBITS


class Recording(Closeable):
    """Collects snapshots during a run and writes the file afterwards.

    The file holds meshcat's page, the robot's meshes and an animation, and needs neither network
    nor server. The animation starts at once and repeats.

    Args:
        robot: Robot to show.
        path: Path that `close` (or leaving the `with` block) saves to.
        rate: Frame rate in plant time, Hz.
        boxes: Terrain as upright boxes: centre, then half sizes, m, shape (n, 6).

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
        self._due = -np.inf
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
            self.show(Snapshot.of_tick(tick, self._contact_plan))

    def end(self, report: Report) -> None:
        """Do nothing; see `wbc.runtime.protocols.Observer`."""

    def show(self, snapshot: Snapshot) -> None:
        """Copy the snapshot if the next frame is due.

        A time before the previous one begins a new run and restarts the recording.

        Raises:
            StateError: `snapshot.q` has the wrong size.
        """
        now = float(snapshot.time)
        if not self._is_due(now):
            return
        if np.shape(snapshot.q) != (self.robot.nq,):
            raise StateError(
                f"snapshot.q has shape {np.shape(snapshot.q)}, the model needs ({self.robot.nq},)"
            )
        if now < self._last:
            self.frames.clear()
            self._due = -np.inf
        self.frames.append(deepcopy(snapshot))
        self._due = next_due(self._due, now, 1.0 / self.rate) - _GRACE
        self._last = now

    def _is_due(self, now: float) -> bool:
        return now >= self._due or now < self._last

    def save(self, path: str | Path) -> Path:
        """Write the file.

        Returns:
            The path of the file.

        Raises:
            ViewerError: nothing was recorded, or the file cannot be written.
        """
        path = Path(path)
        html = self._html()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(html, "utf-8")
        except OSError as error:
            raise ViewerError(
                f"cannot write the recording to {path}: {error.strerror}; give another path"
            ) from error
        return path

    def close(self) -> None:
        """Save to the constructor's path if there is one and the recording has a frame."""
        if self._path is not None and self.frames:
            self.save(self._path)

    def _html(self) -> str:
        # Imported here so that a recorded run does not wait for the drawing modules.
        from wbc.view.objects import set_animation
        from wbc.view.page_text import caption, recorded_page
        from wbc.view.scene import Scene

        scene = Scene(self.robot, self._boxes)
        shown, poses = [], []
        for snapshot in self.frames:
            if scene.update(snapshot):
                shown.append(caption(snapshot))
                poses.append(scene.poses.copy())
        if not shown:
            raise ViewerError("nothing was recorded: show() at least one snapshot before save()")
        times = np.array([w["time"] for w in shown]) - shown[0]["time"]
        track = np.stack(poses)
        duration = max(float(times[-1]), 1.0 / self.rate)
        clips = [
            clip
            for i, (path, node) in enumerate(zip(scene.paths, scene.nodes, strict=True))
            if (clip := _clip(path, node, times, track[:, i], duration)) is not None
        ]
        story = {
            "scale": scene.proportions.top,
            "paths": scene.paths,
            "first": np.round(track[0], 5).ravel().tolist(),
            "caption": shown,
        }
        packer = zlib.compressobj(6, zlib.DEFLATED, _GZIP)
        packed = b"".join(
            packer.compress(struct.pack("<I", len(message)) + message)
            for message in (*scene.commands(), set_animation(clips))
        )
        packed += packer.flush()
        return recorded_page(self.robot.name, story, base64.b64encode(packed).decode("ascii"))


def _clip(
    path: str, node: SceneNode, times: np.ndarray, poses: np.ndarray, duration: float
) -> dict[str, Any] | None:
    """Return the animation clip of a node; None if the node does not move."""
    from wbc.view.objects import floats

    tracks = []
    for name, kind, columns in (
        ("position", "vector3", slice(0, 3)),
        ("quaternion", "quaternion", slice(3, 7)),
        ("scale", "vector3", slice(7, 10)),
    ):
        values = poses[:, columns]
        moved = np.abs(np.diff(values, axis=0)).max(axis=1) > _STILL
        if not moved.any():
            continue
        keys = np.concatenate([[True], moved])
        if node.smooth:
            # The end of each rest is a keyframe, too: otherwise the node would drift.
            keys[:-1] |= moved
        tracks.append(
            {
                "name": f".{name}",
                "type": kind,
                "times": floats(times[keys]),
                "values": floats(values[keys]),
                "interpolation": _LINEAR if node.smooth else _DISCRETE,
            }
        )
    if not tracks:
        return None
    # All clips have the same length, so that they repeat at the same time.
    clip = {"fps": 1, "name": "run", "duration": duration, "tracks": tracks}
    return {"path": path, "clip": clip}

"""`Replay`: a page in the browser with a player for a completed run."""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.runtime.snapshot import Snapshot
from wbc.view.errors import ViewerError
from wbc.view.page_text import caption, viewer_scripts
from wbc.view.recording import Marker
from wbc.view.scene import Scene
from wbc.view.timeline import Timeline, TimeSeries, thinned, up_to
from wbc.view.web import HOST, ScenePage, listen, page_handlers

if TYPE_CHECKING:
    from wbc.robot import Robot

_HISTORY = 8.0  # s, duration of the history that the scene shows (CoM path, footprints)
_POINTS = 1200  # of a series


class Replay:
    """Serves a page with a player: play, pause, speed, and a slider over the whole run.

    Every page plays independently: it requests a time and receives the poses that changed.

    Args:
        robot: Robot to draw.
        timeline: Run to show.
        port: Port of the page on this machine; None takes the first free one from 7000 on, 0
            any.
        boxes: Terrain as boxes: see `wbc.sim.Terrain`.
        series: Quantities drawn over time above the slider.
        markers: Falls and resets, marked above the slider.
    """

    def __init__(
        self,
        robot: Robot,
        timeline: Timeline,
        *,
        port: int | None = None,
        boxes: np.ndarray | None = None,
        series: Sequence[TimeSeries] = (),
        markers: Sequence[Marker] = (),
    ) -> None:
        self._robot = robot
        self._timeline = timeline
        self._port = port
        self._boxes = boxes
        series_json = [_series_json(one) for one in thinned(series, _POINTS)]
        self._described = {"series": series_json, "markers": [asdict(one) for one in markers]}

    def serve(self, ready: Callable[[str], None]) -> None:
        """Serve until interrupted.

        Args:
            ready: Called with the page's address when it is served.

        Raises:
            ViewerError: the port is in use.
        """
        with contextlib.suppress(KeyboardInterrupt):
            asyncio.run(self._serve(ready))

    async def _serve(self, ready: Callable[[str], None]) -> None:
        files = viewer_scripts("socket.js", "player.js", "replay.js")
        page = (
            r"/socket",
            _ReplayPage,
            {"new_scene": self.new_scene, "described": self._described},
        )
        port = listen([page, *page_handlers(self._robot.name, files)], self._port)
        ready(f"http://{HOST}:{port}/static/")
        await asyncio.Event().wait()

    def new_scene(self) -> ReplayScene:
        """Return a scene for one page."""
        return ReplayScene(Scene(self._robot, self._boxes), self._timeline)


class ReplayScene:
    """The scene of one page.

    Args:
        scene: Objects and poses.
        timeline: Run to show.
        history: Duration of the history that the scene shows, s.
    """

    def __init__(self, scene: Scene, timeline: Timeline, history: float = _HISTORY) -> None:
        self.scene, self.timeline = scene, timeline
        self._history = history
        self._time: float | None = None

    def show(self, time: float) -> Snapshot:
        """Update the scene to a time, s, and return its snapshot.

        Raises:
            ViewerError: The time is not a finite number.
        """
        if not math.isfinite(time):
            raise ViewerError(f"time = {time} s must be finite")
        for snapshot in up_to(self.timeline, time, self._time, self._history):
            self.scene.update(snapshot)
        self._time = min(max(time, self.timeline.start), self.timeline.end)
        return snapshot


class _ReplayPage(ScenePage):
    """The web socket of one page, which sends a frame for each request."""

    def initialize(
        self, new_scene: Callable[[], ReplayScene], described: Mapping[str, Any]
    ) -> None:
        self._replay_scene, self._described = new_scene(), described

    async def open(self, *_: str, **__: str) -> None:
        scene, timeline = self._replay_scene.scene, self._replay_scene.timeline
        times = {"start": timeline.start, "end": timeline.end}
        await self.send_objects(scene, scene.commands(), **self._described, **times)

    def on_message(self, message: str | bytes) -> None:
        try:
            snapshot = self._replay_scene.show(float(json.loads(message)["time"]))
        except (ValueError, KeyError, TypeError, AttributeError, ViewerError) as error:
            self.send({"error": f'a request must have the form {{"time": seconds}}: {error}'})
        else:
            self.send_frame(self._replay_scene.scene, caption(snapshot))


def _series_json(series: TimeSeries) -> dict[str, Any]:
    values = [round(float(x), 6) if np.isfinite(x) else None for x in series.values]
    return {"label": series.label, "time": np.round(series.time, 4).tolist(), "values": values}

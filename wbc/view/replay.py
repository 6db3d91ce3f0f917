"""`Replay`: a page in the browser with a player for a completed run."""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.view.errors import ViewerError
from wbc.view.timeline import Timeline, TimeSeries, thinned, up_to

if TYPE_CHECKING:
    from wbc.robot import Robot
    from wbc.view.scene import Scene

_MEMORY = 8.0  # s, duration of the history that the scene shows (CoM path, footprints)
_STILL = 1e-5  # m or 1; smaller changes of a pose are not sent
_POINTS = 1200  # of a series


class Replay:
    """Serves a page with a player: play, pause, speed, and a slider over the whole run.

    Every page plays independently: it requests a time and receives the poses that changed.

    Args:
        robot: Robot to draw.
        timeline: Run to show.
        port: Port of the page on this machine; None takes the first free one from 7000 on, 0
            any.
        boxes: Terrain as upright boxes: centre, then half sizes, m, shape (n, 6).
        series: Quantities drawn over time above the slider.
    """

    def __init__(
        self,
        robot: Robot,
        timeline: Timeline,
        *,
        port: int | None = None,
        boxes: np.ndarray | None = None,
        series: Sequence[TimeSeries] = (),
    ) -> None:
        self._robot = robot
        self._timeline = timeline
        self._port = port
        self._boxes = boxes
        self._series = [_series_json(one) for one in thinned(series, _POINTS, _peaks)]

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
        from wbc.view.web import HOST, listen, page_handlers, protected

        handlers = page_handlers(self._robot.name, ("meshcat.js", "stage.js", "scrub.js"))
        application = protected([(r"/socket", _page(), {"replay": self}), *handlers])
        port = listen(application, self._port)
        ready(f"http://{HOST}:{port}/static/")
        await asyncio.Event().wait()

    def new_scene(self) -> ReplayScene:
        """Return a scene for one page."""
        from wbc.view.scene import Scene

        return ReplayScene(Scene(self._robot, self._boxes), self._timeline)

    def introduction(self, replay_scene: ReplayScene) -> dict[str, Any]:
        """Return the first message to a page, which follows the objects of its scene."""
        return {
            "paths": replay_scene.scene.paths,
            "start": self._timeline.start,
            "end": self._timeline.end,
            "series": self._series,
        }


class ReplayScene:
    """The scene of one page.

    Args:
        scene: Objects and poses.
        timeline: Run to show.
    """

    def __init__(self, scene: Scene, timeline: Timeline) -> None:
        self.scene = scene
        self._timeline = timeline
        self._time: float | None = None
        self._sent: np.ndarray | None = None

    def frame(self, time: float) -> dict[str, Any]:
        """Return the changes to the page that show a time, s.

        Raises:
            ViewerError: The time is not a finite number.
        """
        from wbc.view.page_text import caption

        if not math.isfinite(time):
            raise ViewerError(f"time = {time} s must be finite")
        snapshot = None
        for snapshot in up_to(self._timeline, time, self._time, _MEMORY):
            self.scene.update(snapshot)
        assert snapshot is not None
        self._time = min(max(time, self._timeline.start), self._timeline.end)
        poses = self.scene.poses
        changed = np.arange(len(poses))
        if self._sent is not None:
            changed = np.flatnonzero(np.abs(poses - self._sent).max(axis=1) > _STILL)
        self._sent = poses.copy()
        values = np.round(poses[changed], 5).ravel().tolist()
        return {"caption": caption(snapshot), "nodes": changed.tolist(), "poses": values}


def _page() -> type:
    """Return the class of the page's web socket; imports tornado only when pages are served."""
    import tornado.websocket

    class Page(tornado.websocket.WebSocketHandler):
        def initialize(self, replay: Replay) -> None:
            self.replay = replay

        async def open(self, *_: str, **__: str) -> None:
            self.set_nodelay(True)
            self.replay_scene = stage = self.replay.new_scene()
            with contextlib.suppress(tornado.websocket.WebSocketClosedError):
                await self.write_message(json.dumps({"scale": stage.scene.proportions.top}))
                for body in stage.scene.commands():
                    await self.write_message(body, binary=True)
                await self.write_message(json.dumps(self.replay.introduction(stage)))

        def on_message(self, message: str | bytes) -> None:
            try:
                answer = self.replay_scene.frame(float(json.loads(message)["time"]))
            except (ValueError, KeyError, TypeError, AttributeError, ViewerError) as error:
                answer = {"error": f'a request must have the form {{"time": seconds}}: {error}'}
            with contextlib.suppress(tornado.websocket.WebSocketClosedError):
                self.write_message(json.dumps(answer, separators=(",", ":")))

    return Page


def _peaks(values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Return the maximum of each group, so that thinning keeps the peaks."""
    known = np.where(np.isfinite(values), values, -np.inf)
    return np.asarray(np.maximum.reduceat(known, starts)) if len(values) else values


def _series_json(series: TimeSeries) -> dict[str, Any]:
    values = [round(float(x), 6) if np.isfinite(x) else None for x in series.values]
    return {"label": series.label, "time": np.round(series.time, 4).tolist(), "values": values}

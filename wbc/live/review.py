"""A page that can go back in time while the robot goes on."""

from __future__ import annotations

import asyncio
import json
import math

from wbc.live.history import History
from wbc.view.page_text import caption
from wbc.view.replay import ReplayScene
from wbc.view.scene import Scene
from wbc.view.server import LivePage, LiveScene

_HISTORY = 3.0  # s of the past that the scene shows; more would take too long at every jump


class ReviewPage(LivePage):
    """The web socket of one page, which shows the present or, on request, an earlier time.

    A message `{"time": t}` shows the session time t, s; null returns to the present.
    """

    def initialize(  # type: ignore[override]
        self, live_scene: asyncio.Future[LiveScene], history: History
    ) -> None:
        super().initialize(live_scene)
        self._history = history
        self._replay: ReplayScene | None = None
        self._time: float | None = None
        self._shown: float | None = None

    def on_message(self, message: str | bytes) -> None:
        if not (isinstance(message, str) and message.startswith("{")):
            super().on_message(message)
            return
        try:
            time = json.loads(message)["time"]
            valid = time is None or math.isfinite(time)
        except (ValueError, KeyError, TypeError):
            valid = False
        if not valid:
            self.send({"error": 'a request must have the form {"time": seconds or null}'})
            return
        self._time, self._shown = time, None
        self._frames = -1  # the present is sent anew
        self.offer()

    def offer(self) -> None:
        if self._time is None or not self._live_scene.done():
            super().offer()
        elif not self._busy and self._shown != self._time and len(self._history):
            if self._replay is None:
                live = self._live_scene.result()
                scene = Scene(live.config.robot, live.config.boxes, live.scene.visuals)
                self._replay = ReplayScene(scene, self._history, _HISTORY)
            self._busy, self._shown = True, self._time
            snapshot = self._replay.show(self._time)
            self.send_frame(self._replay.scene, caption(snapshot))

"""The viewer's own process: reads ticks from shared memory and serves the page.

`Meshcat` starts it as `python -m wbc.view.server`; see `wbc.process.child`.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
from typing import Any

import numpy as np
import tornado.websocket

from wbc.process import parent
from wbc.runtime.snapshot import Snapshot
from wbc.runtime.stream import TickReader
from wbc.view.config import ViewerConfig
from wbc.view.due import next_due
from wbc.view.errors import ViewerError
from wbc.view.page_text import caption
from wbc.view.scene import Scene
from wbc.view.web import HOST, listen, page_handlers, protected

#: Smallest change of a pose that is sent, m or 1.
_STILL = 1e-5


class LiveScene:
    """The current scene, and the pages that show it.

    Args:
        config: Configuration of the viewer.

    Attributes:
        reader: Reader of the ticks to show.
        scene: Objects and their poses.
        caption: Texts of the latest frame; None before the first.
        frames: Number of frames so far.
        pages: Open pages.
    """

    def __init__(self, config: ViewerConfig, reader: TickReader) -> None:
        self.reader = reader
        self.scene = Scene(config.robot, config.boxes)
        self.bodies = list(self.scene.commands())
        self.caption: dict[str, Any] | None = None
        self.frames = 0
        self.pages: set[LivePage] = set()
        self._period, self._due = 1.0 / config.rate, 0.0

    def advance(self) -> None:
        """Draw the latest tick and send it to the pages, if a frame is due."""
        now = time.monotonic()
        if now >= self._due and (record := self.reader.latest()) is not None:
            self._due = next_due(self._due, now, self._period)
            snapshot = Snapshot.of_record(record)
            if self.scene.update(snapshot):
                self.caption = caption(snapshot)
                if self.scene.source:
                    self.caption["text"] = f"{snapshot.text}\n({self.scene.source})".strip()
                self.frames += 1
        for page in self.pages:
            page.offer()


class LivePage(tornado.websocket.WebSocketHandler):
    """The web socket of one page, with at most one unacknowledged frame."""

    def initialize(self, live_scene: asyncio.Future[LiveScene]) -> None:
        self.live_scene = live_scene
        self.sent: np.ndarray | None = None
        self.frames = -1
        self.busy = True

    async def open(self, *_: str, **__: str) -> None:
        self.set_nodelay(True)
        live_scene = await self.live_scene
        with contextlib.suppress(tornado.websocket.WebSocketClosedError):
            await self.write_message(json.dumps({"scale": live_scene.scene.proportions.top}))
            for body in live_scene.bodies:
                await self.write_message(body, binary=True)
            await self.write_message(json.dumps({"paths": live_scene.scene.paths}))
            live_scene.pages.add(self)

    def on_message(self, message: str | bytes) -> None:
        self.busy = False
        self.offer()

    def offer(self) -> None:
        """Send the poses that changed, unless a frame is unacknowledged or nothing has changed."""
        live_scene = self.live_scene.result()
        if self.busy or live_scene.caption is None or self.frames == live_scene.frames:
            return
        poses = live_scene.scene.poses
        if self.sent is None:
            changed = np.arange(len(poses))
        else:
            changed = np.flatnonzero(np.abs(poses - self.sent).max(axis=1) > _STILL)
        self.sent = poses.copy()
        self.frames, self.busy = live_scene.frames, True
        values = np.round(poses[changed], 5).ravel().tolist()
        news = {"caption": live_scene.caption, "nodes": changed.tolist(), "poses": values}
        with contextlib.suppress(tornado.websocket.WebSocketClosedError):
            self.write_message(json.dumps(news, separators=(",", ":")))

    def on_close(self) -> None:
        if self.live_scene.done():
            self.live_scene.result().pages.discard(self)


async def serve(config: ViewerConfig) -> None:
    """Serve until the parent has ended."""
    loop = asyncio.get_running_loop()
    reader = TickReader()
    parent_monitor = parent.ParentMonitor(config.parent, reader.on_message)
    live_scene: asyncio.Future[LiveScene] = loop.create_future()
    try:
        pages = page_handlers(config.robot.name, ("meshcat.js", "stage.js", "live.js"))
        application = protected([(r"/socket", LivePage, {"live_scene": live_scene}), *pages])
        port = listen(application, config.port)
    except ViewerError as error:
        parent.reply({"error": str(error)})
        return
    parent.reply({"url": f"http://{HOST}:{port}/static/"})
    live_scene.set_result(await loop.run_in_executor(None, LiveScene, config, reader))
    period = 0.5 / config.rate  # twice the frame rate, which keeps the delay of a frame small
    while not parent_monitor.gone:
        live_scene.result().advance()
        await asyncio.sleep(period)


def main() -> None:
    """Serve the page that the parent's configuration describes."""
    asyncio.run(serve(parent.receive_config()))


if __name__ == "__main__":
    main()

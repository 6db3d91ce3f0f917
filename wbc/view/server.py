"""The viewer's own process: reads snapshots from shared memory, serves the page.

Started by `Meshcat` as `python -m wbc.view.server`. It hears on its standard
input who to draw, answers with its address, and ends when that input does:
a parent that dies, however it dies, takes it along.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
from typing import Any

import numpy as np
import tornado.websocket

from wbc.process import parent
from wbc.view.errors import ViewerError
from wbc.view.order import Order
from wbc.view.page_text import words
from wbc.view.ring import Ring
from wbc.view.scene import Scene
from wbc.view.slot import Layout
from wbc.view.web import HOST, listen, page_handlers, protected

#: A pose that changed by less than this, m or 1, has not changed.
_STILL = 1e-5


class Show:
    """The state of the show and its audience."""

    def __init__(self, order: Order) -> None:
        self.ring = Ring(Layout.of(order.robot.model), order.descriptor)
        self.scene = Scene(order.robot, order.boxes)
        self.bodies = list(self.scene.commands())
        self.words: dict[str, Any] | None = None
        self.frames = 0
        self.pages: set[Page] = set()

    def advance(self) -> None:
        """Take the latest snapshot, if there is one, and tell the pages."""
        snapshot = self.ring.read()
        if snapshot is not None and self.scene.update(snapshot):
            self.words = words(snapshot)
            if self.scene.source:
                self.words["text"] = f"{snapshot.text}\n({self.scene.source})".strip()
            self.frames += 1
        for page in self.pages:
            page.offer()


class Page(tornado.websocket.WebSocketHandler):
    """One open browser page. At most one frame is on its way to it."""

    def initialize(self, show: asyncio.Future[Show]) -> None:
        self.show = show
        self.sent: np.ndarray | None = None
        self.frames = -1
        self.busy = True

    async def open(self, *_: str, **__: str) -> None:
        self.set_nodelay(True)
        show = await self.show
        with contextlib.suppress(tornado.websocket.WebSocketClosedError):
            await self.write_message(json.dumps({"scale": show.scene.proportions.top}))
            for body in show.bodies:
                await self.write_message(body, binary=True)
            await self.write_message(json.dumps({"paths": show.scene.paths}))
            show.pages.add(self)

    def on_message(self, message: str | bytes) -> None:
        self.busy = False
        self.offer()

    def offer(self) -> None:
        """Send what changed, unless the page is still at work or knows it already."""
        show = self.show.result()
        if self.busy or show.words is None or self.frames == show.frames:
            return
        poses = show.scene.poses
        if self.sent is None:
            changed = np.arange(len(poses))
        else:
            changed = np.flatnonzero(np.abs(poses - self.sent).max(axis=1) > _STILL)
        self.sent = poses.copy()
        self.frames, self.busy = show.frames, True
        values = np.round(poses[changed], 5).ravel().tolist()
        news = {"words": show.words, "nodes": changed.tolist(), "poses": values}
        with contextlib.suppress(tornado.websocket.WebSocketClosedError):
            self.write_message(json.dumps(news, separators=(",", ":")))

    def on_close(self) -> None:
        if self.show.done():
            self.show.result().pages.discard(self)


async def serve(order: Order) -> None:
    """Serve until the parent is gone."""
    loop = asyncio.get_running_loop()
    parent_monitor = parent.ParentMonitor(order.parent)
    show: asyncio.Future[Show] = loop.create_future()
    try:
        pages = page_handlers(order.robot.name, ("meshcat.js", "stage.js", "live.js"))
        application = protected([(r"/socket", Page, {"show": show}), *pages])
        port = listen(application, order.port)
    except ViewerError as error:
        parent.reply({"error": str(error)})
        return
    parent.reply({"url": f"http://{HOST}:{port}/static/"})
    show.set_result(await loop.run_in_executor(None, Show, order))
    period = 0.5 / order.rate  # twice as often as snapshots come: none waits long
    while not parent_monitor.gone:
        show.result().advance()
        await asyncio.sleep(period)


def main() -> None:
    """Read the order and serve it."""
    asyncio.run(serve(parent.receive_config()))


if __name__ == "__main__":
    main()

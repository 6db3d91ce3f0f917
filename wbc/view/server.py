"""The viewer's own process: reads snapshots from shared memory, serves the page.

Started by `Meshcat` as `python -m wbc.view.server`. It hears on its standard
input who to draw, answers with its address, and ends when that input does:
a parent that dies, however it dies, takes it along.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import threading
from typing import Any

import numpy as np
import tornado.httpserver
import tornado.netutil
import tornado.web
import tornado.websocket

from wbc.process import parent
from wbc.view.errors import ViewerError
from wbc.view.order import Order
from wbc.view.page_text import live_page, script, words
from wbc.view.ring import Ring
from wbc.view.scene import Scene
from wbc.view.slot import Layout

HOST = "127.0.0.1"
FIRST_PORT = 7000
_PORTS = 200
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


class Text(tornado.web.RequestHandler):
    """A page or a script."""

    def initialize(self, text: str, kind: str) -> None:
        self.text, self.kind = text, kind

    def get(self) -> None:
        self.set_header("Content-Type", f"{self.kind}; charset=utf-8")
        self.set_header("Cache-Control", "no-store")
        self.finish(self.text)


def _application(name: str, show: asyncio.Future[Show]) -> tornado.web.Application:
    page = {"text": live_page(name), "kind": "text/html"}
    handlers: list[Any] = [
        (r"/socket", Page, {"show": show}),
        (r"/(?:static/)?", Text, page),
    ]
    for source in ("meshcat.js", "stage.js", "live.js"):
        route = {"text": script(source), "kind": "text/javascript"}
        handlers.append((rf"/(?:static/)?{source}", Text, route))
    # Only requests for this machine by its own name: other sites cannot reach in.
    application = tornado.web.Application()
    application.add_handlers(r"(127\.0\.0\.1|localhost)", handlers)
    return application


def _listen(application: tornado.web.Application, port: int | None) -> int:
    server = tornado.httpserver.HTTPServer(application)
    for candidate in range(FIRST_PORT, FIRST_PORT + _PORTS) if port is None else (port,):
        with contextlib.suppress(OSError):
            sockets = tornado.netutil.bind_sockets(candidate, HOST)
            server.add_sockets(sockets)
            return int(sockets[0].getsockname()[1])
    what = f"port {port} is" if port is not None else f"all ports from {FIRST_PORT} on are"
    raise ViewerError(f"{what} in use on {HOST}; give another port, or port=0 for any")


async def serve(order: Order) -> None:
    """Serve until the parent is gone."""
    loop = asyncio.get_running_loop()
    done = asyncio.Event()
    threading.Thread(target=_wait_for_end, args=(loop, done), daemon=True).start()
    show: asyncio.Future[Show] = loop.create_future()
    try:
        port = _listen(_application(order.robot.name, show), order.port)
    except ViewerError as error:
        parent.answer({"error": str(error)})
        return
    parent.answer({"url": f"http://{HOST}:{port}/static/"})
    show.set_result(await loop.run_in_executor(None, Show, order))
    period = 0.5 / order.rate  # twice as often as snapshots come: none waits long
    while not done.is_set() and os.getppid() == order.parent:
        show.result().advance()
        with contextlib.suppress(asyncio.TimeoutError):
            await asyncio.wait_for(done.wait(), period)


def _wait_for_end(loop: asyncio.AbstractEventLoop, done: asyncio.Event) -> None:
    while parent.hear() is not None:
        pass
    with contextlib.suppress(RuntimeError):
        loop.call_soon_threadsafe(done.set)


def main() -> None:
    """Read the order and serve it."""
    asyncio.run(serve(parent.begin()))


if __name__ == "__main__":
    main()

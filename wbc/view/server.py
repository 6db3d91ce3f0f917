"""The viewer's own process: reads ticks from shared memory and serves the page.

`Meshcat` starts it as `python -m wbc.view.server`; see `wbc.process.child`.
"""

from __future__ import annotations

import asyncio
import time
from pathlib import Path
from typing import Any

from wbc.errors import WbcError
from wbc.process import ParentConnection
from wbc.runtime.rate_limiter import RateLimiter
from wbc.runtime.snapshot import Snapshot
from wbc.runtime.stream import TickReader
from wbc.view.config import ViewerConfig
from wbc.view.page_text import caption, viewer_scripts
from wbc.view.web import HOST, ScenePage, listen, page_handlers

ENDED = 1000  # code by which a connection is closed at the end of a run
_CLOSING = 0.1  # s, for the pages to be told


class LiveScene:
    """The current scene, and the pages that show it.

    Args:
        config: Configuration of the viewer.
        reader: Reader of the ticks to show.

    Attributes:
        config: See above.
        scene: Objects and their poses.
        commands: Commands that create the objects.
        caption: Texts of the latest frame; None before the first.
        frames: Number of frames so far.
        pages: Open pages.
    """

    def __init__(self, config: ViewerConfig, reader: TickReader) -> None:
        # Imported here because it takes long: the page is already served meanwhile.
        from wbc.view.scene import Scene

        self._reader = reader
        self.config = config
        self.scene = Scene(config.robot, config.boxes)
        self.commands = list(self.scene.commands())
        self.caption: dict[str, Any] | None = None
        self.frames = 0
        self.pages: set[LivePage] = set()
        self._limiter = RateLimiter(config.rate)

    def advance(self) -> None:
        """Draw the latest tick and send it to the pages, if a frame is due."""
        if self._limiter.is_due(time.monotonic()):
            record = self._reader.latest()
            if record is not None and self.scene.update(snapshot := Snapshot.of_record(record)):
                self.caption = caption(snapshot)
                if self.scene.source:
                    self.caption["text"] = f"{snapshot.text}\n({self.scene.source})".strip()
                self.frames += 1
        for page in self.pages:
            page.offer()


class LivePage(ScenePage):
    """The web socket of one page, with at most one unacknowledged frame."""

    def initialize(self, live_scene: asyncio.Future[LiveScene]) -> None:
        self._live_scene = live_scene
        self._frames = -1
        self._busy = True

    async def open(self, *_: str, **__: str) -> None:
        live_scene = await self._live_scene
        live_scene.pages.add(self)
        await self.send_objects(live_scene.scene, live_scene.commands)

    def on_message(self, message: str | bytes) -> None:
        self._busy = False
        self.offer()

    def offer(self) -> None:
        """Send a frame, unless one is unacknowledged or there is no new one."""
        live_scene = self._live_scene.result()
        if self._busy or live_scene.caption is None or self._frames == live_scene.frames:
            return
        self._frames, self._busy = live_scene.frames, True
        self.send_frame(live_scene.scene, live_scene.caption)

    def on_close(self) -> None:
        # The page may close before the scene is complete, or while its objects are sent.
        self._live_scene.add_done_callback(lambda done: done.result().pages.discard(self))


class SceneServer:
    """Serves the page of a running loop until the parent process ends.

    Args:
        config: Configuration of the viewer.

    Attributes:
        reader: Reader of the ticks.
        live_scene: The scene, once its meshes are read.
    """

    def __init__(self, config: ViewerConfig) -> None:
        self.config = config
        self.reader = TickReader()
        self.live_scene: asyncio.Future[LiveScene] = asyncio.get_running_loop().create_future()

    def listen(self) -> str:
        """Listen on the port; return the address of the page.

        Raises:
            WbcError: The port is in use, or meshcat is not installed.
        """
        port = listen(self.handlers(), self.config.port)
        return f"http://{HOST}:{port}/static/"

    def files(self) -> list[Path]:
        """Return the paths of the page's scripts and style sheets."""
        return viewer_scripts("socket.js", "live.js")

    def handlers(self) -> list[Any]:
        """Return the request handlers."""
        socket = (r"/socket", LivePage, {"live_scene": self.live_scene})
        return [socket, *page_handlers(self.config.robot.name, self.files())]

    def start(self) -> None:
        """Do nothing; called once, when the scene is complete."""

    def advance(self) -> None:
        """Send what is new to the pages; called at twice the frame rate."""
        self.live_scene.result().advance()

    async def serve(self, parent: ParentConnection) -> None:
        """Serve until the parent process has ended."""
        parent.listen(self.reader.on_message)
        try:
            parent.reply({"url": self.listen()})
        except WbcError as error:
            parent.reply({"error": str(error)})
            return
        loop = asyncio.get_running_loop()
        scene = await loop.run_in_executor(None, LiveScene, self.config, self.reader)
        self.live_scene.set_result(scene)
        self.start()
        period = 0.5 / self.config.rate  # half of a frame's, which keeps the delay of a frame small
        while not parent.gone:
            self.advance()
            await asyncio.sleep(period)
        for page in tuple(scene.pages):
            page.close(ENDED, "the run has ended")
        await asyncio.sleep(_CLOSING)


async def main() -> None:
    """Serve the page that the parent's configuration describes."""
    parent = ParentConnection()
    await SceneServer(parent.config).serve(parent)


if __name__ == "__main__":
    asyncio.run(main())

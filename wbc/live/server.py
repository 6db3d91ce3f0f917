"""The process of the live page: it shows ticks to browsers and passes on their commands.

`Live` starts it as `python -m wbc.live.server`; see `wbc.process.child`.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import tornado.websocket

from wbc.live.address import allowed_hosts, check_host, is_local, url_host
from wbc.live.broker import RequestBroker
from wbc.live.config import LiveServerConfig
from wbc.live.description_check import examined
from wbc.live.history import History
from wbc.live.review import ReviewPage
from wbc.live.saving import SavedFiles
from wbc.live.uploads import ROBOT_SUFFIXES, Uploads
from wbc.motions.engine import SWITCH_INTERVAL
from wbc.process import ParentConnection
from wbc.teleop import CommandRefused
from wbc.view.server import SceneServer
from wbc.view.web import GuardedHandler, Text, listen

_HERE = Path(__file__).parent / "page"
_FILES = (
    "uPlot.iife.js", "uPlot.min.css", "elements.js", "session.js", "parameters.js", "strips.js",
    "timeline.js", "camera.js", "pointer.js", "keys.js", "why.js", "tasks.js",
    "panel.js", "panel.css",
)  # fmt: skip
_MAX_SIZE = 1 << 16  # bytes; a longer message ends the connection
_MAX_UNSENT_STATUS = 100  # messages to a page that does not read; further statuses are dropped
_MAX_UNSENT = 10_000  # messages, among them answers, after which such a page is disconnected


class ControlSocket(GuardedHandler, tornado.websocket.WebSocketHandler):
    """The control connection of one open page. Tornado refuses pages of other origins."""

    def initialize(self, broker: RequestBroker) -> None:
        self._broker = broker
        self._unsent = 0
        self.local = is_local(self.request.remote_ip or "")

    def open(self, *_: str, **__: str) -> None:
        self.set_nodelay(True)
        self._broker.add_page(self)

    async def on_message(self, message: str | bytes) -> None:
        self._broker.handle(message, self)
        await asyncio.sleep(0)  # a page that sends much does not keep the others waiting

    def send(self, message: dict[str, Any]) -> None:
        """Send a message as JSON; a page that reads nothing for long is disconnected."""
        if self._unsent > _MAX_UNSENT:
            self.close()
            return
        with contextlib.suppress(tornado.websocket.WebSocketClosedError):
            self._unsent += 1
            written = self.write_message(json.dumps(message, separators=(",", ":")))
            written.add_done_callback(self._on_sent)

    def send_status(self, message: dict[str, Any]) -> None:
        """Send a message as JSON, unless the page reads too slowly."""
        if self._unsent <= _MAX_UNSENT_STATUS:
            self.send(message)

    def _on_sent(self, written: asyncio.Future[None]) -> None:
        self._unsent -= 1
        if not written.cancelled():
            written.exception()  # retrieved, so that a closed page causes no warning

    def on_close(self) -> None:
        self._broker.remove_page(self)


class AliveSocket(GuardedHandler, tornado.websocket.WebSocketHandler):
    """The connection by which the worker of a page says that the page is there."""

    def initialize(self, broker: RequestBroker) -> None:
        self._broker = broker

    def on_message(self, message: str | bytes) -> None:
        self._broker.on_alive(self.get_query_argument("page", ""))


class SavedFile(GuardedHandler):
    """The handler of a file that a page has asked for."""

    def initialize(self, files: SavedFiles) -> None:
        self._files = files

    def get(self, token: str, name: str) -> None:
        path = self._files.path(token, name)
        if path is None:
            self.send_error(404)
            return
        self.set_header("Content-Type", "application/octet-stream")
        self.set_header("Content-Disposition", f'attachment; filename="{name}"')
        self.finish(path.read_bytes())


class Upload(GuardedHandler):
    """The handler that takes a file from a page, and answers with its name and findings."""

    def initialize(self, broker: RequestBroker, uploads: Uploads) -> None:
        self._broker, self._uploads = broker, uploads

    def prepare(self) -> None:
        super().prepare()
        # A page of another origin can send a request here, with the browser's cookies.
        origin = urlsplit(self.request.headers.get("Origin", "")).netloc
        if not self._finished and origin != self.request.host:
            self.send_error(403)

    async def post(self, name: str) -> None:
        try:
            found = self._uploads.save(unquote(name), self.request.body)
        except (CommandRefused, OSError) as error:
            self.finish({"error": str(error)})
            return
        findings = []
        if found.endswith(ROBOT_SUFFIXES):
            findings = await examined(self._uploads.find(found, ROBOT_SUFFIXES))
        self.finish({"name": found, "findings": findings})
        self._broker.announce_files()


class LiveServer(SceneServer):
    """Serves the scene and the controls until the parent process ends.

    Args:
        config: Configuration of the server.
    """

    def __init__(self, config: LiveServerConfig) -> None:
        super().__init__(config)
        self._host, self._token = config.host, config.token
        self._history = History(config.robot, config.dt)
        self._files = SavedFiles(config.robot.name, config.uploads)
        self._uploads = Uploads(config.uploads)
        self._broker = RequestBroker(config, self.reader, self._history, self._files, self._uploads)

    def listen(self) -> str:
        check_host(self._host)
        names = allowed_hosts(self._host)
        size = {"websocket_max_message_size": _MAX_SIZE}
        port = listen(self.handlers(), self.config.port, self._host, names, self._token, **size)
        query = f"?token={self._token}" if self._token else ""
        return f"http://{url_host(self._host)}:{port}/static/{query}"

    def files(self) -> list[Path]:
        return [*super().files(), *(_HERE / name for name in _FILES)]

    def handlers(self) -> list[Any]:
        broker = {"broker": self._broker}
        worker = {"text": (_HERE / "alive.js").read_text("utf-8"), "kind": "text/javascript"}
        review = {"live_scene": self.live_scene, "history": self._history}
        return [
            (r"/socket", ReviewPage, review),
            (r"/controls", ControlSocket, broker),
            (r"/alive", AliveSocket, broker),
            (r"/static/alive.js", Text, worker),
            (r"/saved/([0-9a-f]+)/([\w.-]+)", SavedFile, {"files": self._files}),
            (r"/upload/([^/]+)", Upload, {**broker, "uploads": self._uploads}),
            *super().handlers(),
        ]

    def start(self) -> None:
        self._broker.start_planning()

    def advance(self) -> None:
        super().advance()
        self._broker.advance()

    async def serve(self, parent: ParentConnection) -> None:
        with contextlib.closing(self._files):
            await super().serve(parent)


async def main() -> None:
    """Serve the page that the parent's configuration describes."""
    sys.setswitchinterval(SWITCH_INTERVAL)
    parent = ParentConnection()
    await LiveServer(parent.config).serve(parent)


if __name__ == "__main__":
    asyncio.run(main())

"""The process that serves the live page: it shows ticks to browsers and passes requests on.

`Live` starts it as `python -m wbc.live.server`. It ends when its standard input is closed: a parent
that dies, even by SIGKILL, ends it.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
import sys
from pathlib import Path
from typing import Any

import tornado.websocket

from wbc.live.address import allowed_hosts, check_host, url_host
from wbc.live.broker import RequestBroker
from wbc.live.config import LiveServerConfig
from wbc.live.errors import LiveError
from wbc.live.series import SeriesList, SeriesSocket
from wbc.motions.engine import SWITCH_INTERVAL
from wbc.process import parent
from wbc.runtime.stream import TickReader
from wbc.view.config import ViewerConfig
from wbc.view.errors import ViewerError
from wbc.view.page_text import script, served_page
from wbc.view.server import LivePage, LiveScene
from wbc.view.web import Text, listen, protected

_HERE = Path(__file__).parent / "page"
_VIEW = ("meshcat.js", "stage.js", "live.js")
_SCRIPTS = ("parts.js", "parameters.js", "strips.js", "panel.js")
_OWN = (*_SCRIPTS, "panel.css")
_MAX_SIZE = 1 << 16  # bytes: a longer message ends the connection
_MAX_UNSENT = 100  # messages to a page that does not read; further ones are dropped


class ControlSocket(tornado.websocket.WebSocketHandler):
    """The control connection of one open page. Tornado refuses pages of another origin."""

    def initialize(self, broker: RequestBroker) -> None:
        self.broker = broker
        self._unsent = 0

    def open(self, *_: str, **__: str) -> None:
        self.set_nodelay(True)
        self.broker.welcome(self)

    def on_message(self, message: str | bytes) -> None:
        self.broker.handle(message, self)

    def send(self, text: str) -> None:
        """Send a text, unless the page is gone or reads too slowly."""
        if self._unsent > _MAX_UNSENT:
            return

        with contextlib.suppress(tornado.websocket.WebSocketClosedError):
            self._unsent += 1
            self.write_message(text).add_done_callback(self._on_sent)

    def _on_sent(self, written: asyncio.Future[None]) -> None:
        self._unsent -= 1
        if not written.cancelled():
            written.exception()  # retrieved, so that a page that is gone causes no warning

    def on_close(self) -> None:
        self.broker.pages.discard(self)


async def serve(config: LiveServerConfig) -> None:
    """Serve until the parent is gone."""
    loop = asyncio.get_running_loop()
    reader = TickReader()
    monitor = parent.ParentMonitor(config.parent, reader.on_message)
    scene: asyncio.Future[LiveScene] = loop.create_future()
    broker = RequestBroker(config, reader)
    try:
        check_host(config.host)
        handlers = [
            (r"/socket", LivePage, {"live_scene": scene}),
            (r"/controls", ControlSocket, {"broker": broker}),
            (r"/series", SeriesSocket, {"source": broker.series}),
            (r"/quantities.json", SeriesList, {"source": broker.series}),
            *_files(config.robot.name),
        ]
        hosts = allowed_hosts(config.host)
        application = protected(handlers, hosts, websocket_max_message_size=_MAX_SIZE)
        port = listen(application, config.port, config.host)
    except (LiveError, ViewerError) as error:
        parent.reply({"error": str(error)})
        return
    parent.reply({"url": f"http://{url_host(config.host)}:{port}/static/"})
    drawn = ViewerConfig(config.robot, config.port, config.rate, config.boxes, config.parent)
    scene.set_result(await loop.run_in_executor(None, LiveScene, drawn, reader))
    broker.start_planning()
    period = 0.5 / config.rate  # twice as often as frames are due: none waits long
    even = False
    while not monitor.gone:
        scene.result().advance()
        even = not even
        if even:
            broker.advance()
        await asyncio.sleep(period)


def _files(name: str) -> list[Any]:
    """Return handlers of the page, its scripts and its style."""
    page = served_page(name, (*_VIEW, *_SCRIPTS))
    page = page.replace("</head>", '<link rel="stylesheet" href="panel.css">\n</head>')
    texts = [("", page, "text/html")]
    texts += [(source, script(source), "text/javascript") for source in _VIEW]
    for source in _OWN:
        kind = "text/css" if source.endswith(".css") else "text/javascript"
        texts.append((source, (_HERE / source).read_text("utf-8"), kind))
    return [
        (rf"/(?:static/)?{re.escape(path)}", Text, {"text": text, "kind": kind})
        for path, text, kind in texts
    ]


def main() -> None:
    """Receive the configuration and serve."""
    sys.setswitchinterval(SWITCH_INTERVAL)
    asyncio.run(serve(parent.receive_config()))


if __name__ == "__main__":
    main()

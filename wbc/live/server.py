"""The page's own process: shows the loop's ticks to browsers, and passes requests on.

Started by `Live` as `python -m wbc.live.server`. It ends when its standard input does: a parent
that dies, however it dies, takes it along.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
import socket
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import tornado.websocket

from wbc.live.desk import Desk
from wbc.live.order import Order
from wbc.motions.engine.planning import SWITCH_INTERVAL
from wbc.process import parent
from wbc.view.errors import ViewerError
from wbc.view.order import Order as ViewOrder
from wbc.view.page_text import script, served_page
from wbc.view.server import Page, Show
from wbc.view.web import HOST, LOOPBACK, Text, listen, protected

_HERE = Path(__file__).parent / "page"
_VIEW = ("meshcat.js", "stage.js", "live.js")
_SCRIPTS = ("parts.js", "parameters.js", "strips.js", "panel.js")
_OWN = (*_SCRIPTS, "panel.css")
_BIGGEST = 1 << 16  # bytes: a longer message ends the connection


class Controls(tornado.websocket.WebSocketHandler):
    """The control side of one open page. Tornado refuses it to pages of another origin."""

    def initialize(self, desk: Desk) -> None:
        self.desk = desk
        self._unsent = 0

    def open(self, *_: str, **__: str) -> None:
        self.set_nodelay(True)
        self.desk.welcome(self)

    def on_message(self, message: str | bytes) -> None:
        self.desk.ask(message, self)

    def say(self, text: str) -> None:
        """Send, unless the page is gone, or so slow that it had better miss something."""
        if self._unsent > 100:
            return

        with contextlib.suppress(tornado.websocket.WebSocketClosedError):
            self._unsent += 1
            self.write_message(text).add_done_callback(self._sent)

    def _sent(self, written: asyncio.Future[None]) -> None:
        self._unsent -= 1
        if not written.cancelled():
            written.exception()  # a page that is gone has heard enough

    def on_close(self) -> None:
        self.desk.visitors.discard(self)


async def serve(order: Order) -> None:
    """Serve until the parent is gone."""
    loop = asyncio.get_running_loop()
    parent_monitor = parent.ParentMonitor(order.parent)
    show: asyncio.Future[Show] = loop.create_future()

    def later(call: Callable[[], None]) -> None:
        with contextlib.suppress(RuntimeError):  # it was the end meanwhile
            loop.call_soon_threadsafe(call)

    desk = Desk(order, later)
    try:
        handlers = [
            (r"/socket", Page, {"show": show}),
            (r"/controls", Controls, {"desk": desk}),
            *_texts(order.robot.name),
        ]
        application = protected(handlers, _names(order.host), websocket_max_message_size=_BIGGEST)
        port = listen(application, order.port, order.host)
    except ViewerError as error:
        parent.reply({"error": str(error)})
        return
    parent.reply({"url": f"http://{_shown(order.host)}:{port}/static/"})
    drawn = ViewOrder(
        order.robot, order.snapshots, order.port, order.rate, order.boxes, order.parent
    )
    show.set_result(await loop.run_in_executor(None, Show, drawn))
    desk.start_planning()
    period = 0.5 / order.rate  # twice as often as snapshots come: none waits long
    even = False
    while not parent_monitor.gone:
        show.result().advance()
        even = not even
        if even:
            desk.advance()
        await asyncio.sleep(period)


def _texts(name: str) -> list[Any]:
    """The page, its scripts and its style."""
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


def _names(host: str) -> str:
    """By which names the page may be asked for.

    A name that somebody else can make point here (DNS rebinding) is never among them.
    """
    if host in (HOST, "localhost"):
        return LOOPBACK
    if host in ("", "0.0.0.0", "::"):
        mine = re.escape(socket.gethostname())
        return rf"(localhost|{mine}|[0-9.]+|\[?[0-9a-fA-F:.]+\]?)"
    return rf"({LOOPBACK}|\[?{re.escape(host)}\]?)"


def _shown(host: str) -> str:
    """How a browser is told the address."""
    if host in ("", "0.0.0.0", "::"):
        return socket.gethostname()
    return f"[{host}]" if ":" in host else host


def main() -> None:
    """Read the order and serve it."""
    sys.setswitchinterval(SWITCH_INTERVAL)
    asyncio.run(serve(parent.receive_config()))


if __name__ == "__main__":
    main()

"""The page's own process: shows the loop's ticks to browsers, and passes requests on.

Started by `Live` as `python -m wbc.live.server`. It ends when its standard input does: a parent
that dies, however it dies, takes it along.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import re
import socket
import threading
import time
from pathlib import Path
from typing import Any

import tornado.websocket

from wbc.errors import MotionError
from wbc.live.errors import BadRequest
from wbc.live.gauges import SIZE, Gauges
from wbc.live.helm import RECORD
from wbc.live.order import Order
from wbc.live.panel import Kind, Request
from wbc.process import RecordRing, parent
from wbc.view.errors import ViewerError
from wbc.view.order import Order as ViewOrder
from wbc.view.page_text import script, served_page
from wbc.view.server import Page, Show
from wbc.view.web import HOST, LOOPBACK, Text, listen, protected

_HERE = Path(__file__).parent / "page"
_VIEW = ("meshcat.js", "stage.js", "live.js")
_OWN = ("panel.js", "panel.css")
_OPEN = 32  # requests that the loop may owe
_BIGGEST = 1 << 16  # bytes: a longer message ends the connection


class Desk:
    """Knows what the page offers, what stands where, and who looks at it."""

    def __init__(self, order: Order) -> None:
        self.panel = order.panel
        self._robot = order.robot
        self._gauges = RecordRing(SIZE, order.gauges)
        self._requests = RecordRing(RECORD, order.requests)
        self._sent = self._taken = 0
        self._run = 0
        self.values = {knob.name: knob.value for knob in order.panel.knobs}
        self._unable: dict[int, str] = {}
        self.desks: set[Controls] = set()

    def check_motions(self, loop: asyncio.AbstractEventLoop) -> None:
        """Find out which motions this robot cannot do, and tell the pages; takes a while."""
        for i in range(len(self.panel.motions)):
            self.check_motion(i)
        with contextlib.suppress(RuntimeError):  # it was the end meanwhile
            loop.call_soon_threadsafe(lambda: self.tell({"unable": self.unable}))

    def check_motion(self, index: int) -> str:
        """Why the robot cannot do a motion; empty when it can."""
        if index not in self._unable:
            try:
                self.panel.motions[index]().check(self._robot)
                self._unable[index] = ""
            except MotionError as error:
                self._unable[index] = str(error)
        return self._unable[index]

    @property
    def unable(self) -> dict[str, str]:
        """Motion -> why the robot cannot do it."""
        return {self.panel.motions[i].name: why for i, why in self._unable.items() if why}

    def pass_on(self, request: Request, sender: Controls) -> None:
        """Give a request to the loop, and tell the other pages where a knob stands.

        Raises:
            BadRequest: the loop does not take any.
        """
        if self._sent - self._taken >= _OPEN:
            raise BadRequest("too many requests at once: the loop takes them between its ticks")
        record = self._requests.begin()
        record[:] = (request.kind, request.first, request.second)
        self._requests.publish()
        self._sent += 1
        if request.kind is Kind.KNOB:
            knob = self.panel.knobs[int(request.first)]
            self.values[knob.name] = request.second
            self.tell({"values": {knob.name: request.second}}, but=sender)
        elif request.kind in (Kind.MOTION, Kind.STAND, Kind.RESET):
            self.let_stand()

    def let_stand(self) -> None:
        """The velocity's knobs go back to zero, as the loop's wish does."""
        zeros = {k.name: 0.0 for k in self.panel.knobs if k.group == "velocity"}
        self.values.update(zeros)
        self.tell({"values": zeros})

    def advance(self) -> None:
        """Read the gauges, and tell the pages."""
        ticks = [Gauges.of(record) for record in self._gauges.read()]
        if not ticks:
            return
        last = ticks[-1]
        self._taken = last.taken
        if last.run != self._run:
            self._run = last.run
            self.let_stand()
        self.tell({"gauges": _summary(ticks)})

    def tell(self, news: dict[str, Any], but: Controls | None = None) -> None:
        """Say something to the pages."""
        text = json.dumps(news, separators=(",", ":"))
        for desk in tuple(self.desks):
            if desk is not but:
                desk.say(text)


def _summary(ticks: list[Gauges]) -> dict[str, Any]:
    """The last tick, with the worst of all of them."""
    last = ticks[-1]
    return {
        "stamp": round(time.monotonic(), 3),
        "time": round(last.time, 4),
        "mode": last.mode.name.lower(),
        "dcm_error": _rounded(max(tick.dcm_error for tick in ticks)),
        "tick_time": _rounded(max(tick.tick_time for tick in ticks)),
        "velocity": [_rounded(x) for x in (last.forward, last.left, last.turn)],
        "playing": last.playing,
        "pushes": last.pushes,
        "survived": last.survived,
    }


def _rounded(value: float) -> float | None:
    return round(value, 6) if abs(value) < float("inf") else None


class Controls(tornado.websocket.WebSocketHandler):
    """The control side of one open page. Tornado refuses it to pages of another origin."""

    def initialize(self, desk: Desk) -> None:
        self.desk = desk
        self._unsent = 0

    def open(self, *_: str, **__: str) -> None:
        self.set_nodelay(True)
        desk = self.desk
        for news in (
            {"panel": desk.panel.describe()},
            {"values": desk.values, "unable": desk.unable},
        ):
            self.say(json.dumps(news))
        desk.desks.add(self)

    async def on_message(self, message: str | bytes) -> None:
        try:
            request = self.desk.panel.request(message)
            if request.kind is Kind.MOTION:
                check = self.desk.check_motion
                loop = asyncio.get_running_loop()
                why = await loop.run_in_executor(None, check, int(request.first))
                if why:
                    raise BadRequest(why)
            self.desk.pass_on(request, self)
        except BadRequest as error:
            self.say(json.dumps({"error": str(error)}))

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
        self.desk.desks.discard(self)


async def serve(order: Order) -> None:
    """Serve until the parent is gone."""
    loop = asyncio.get_running_loop()
    done = asyncio.Event()
    threading.Thread(target=_wait_for_end, args=(loop, done), daemon=True).start()
    show: asyncio.Future[Show] = loop.create_future()
    desk = Desk(order)
    try:
        handlers = [
            (r"/socket", Page, {"show": show}),
            (r"/controls", Controls, {"desk": desk}),
            *_texts(order.robot.name),
        ]
        application = protected(handlers, _names(order.host), websocket_max_message_size=_BIGGEST)
        port = listen(application, order.port, order.host)
    except ViewerError as error:
        parent.answer({"error": str(error)})
        return
    parent.answer({"url": f"http://{_shown(order.host)}:{port}/static/"})
    drawn = ViewOrder(
        order.robot, order.snapshots, order.port, order.rate, order.boxes, order.parent
    )
    show.set_result(await loop.run_in_executor(None, Show, drawn))
    # A thread that nobody waits for in the end.
    threading.Thread(target=desk.check_motions, args=(loop,), daemon=True).start()
    period = 0.5 / order.rate  # twice as often as snapshots come: none waits long
    even = False
    while not done.is_set() and os.getppid() == order.parent:
        show.result().advance()
        even = not even
        if even:
            desk.advance()
        with contextlib.suppress(asyncio.TimeoutError):
            await asyncio.wait_for(done.wait(), period)


def _texts(name: str) -> list[Any]:
    """The page, its scripts and its style."""
    page = served_page(name, (*_VIEW, "panel.js"))
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

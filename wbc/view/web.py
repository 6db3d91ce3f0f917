"""Serves pages to this machine: their files, their port, and a check of the host name."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import Any

import tornado.httpserver
import tornado.netutil
import tornado.web

from wbc.view.errors import ViewerError
from wbc.view.page_text import script, served_page

HOST = "127.0.0.1"
LOOPBACK = r"(127\.0\.0\.1|localhost)"
FIRST_PORT = 7000
_PORTS = 200


class Text(tornado.web.RequestHandler):
    """The handler of a page or a script."""

    def initialize(self, text: str, kind: str) -> None:
        self.text, self.kind = text, kind

    def get(self) -> None:
        self.set_header("Content-Type", f"{self.kind}; charset=utf-8")
        self.set_header("Cache-Control", "no-store")
        self.finish(self.text)


def page_handlers(name: str, sources: Sequence[str]) -> list[Any]:
    """Return the handlers of a page and its scripts.

    Args:
        name: Name of the robot.
        sources: Names of the scripts.
    """
    page = {"text": served_page(name, sources), "kind": "text/html"}
    handlers: list[Any] = [(r"/(?:static/)?", Text, page)]
    for source in sources:
        route = {"text": script(source), "kind": "text/javascript"}
        handlers.append((rf"/(?:static/)?{source}", Text, route))
    return handlers


def protected(
    handlers: Sequence[Any], names: str = LOOPBACK, **settings: Any
) -> tornado.web.Application:
    """Return an application that rejects requests for other host names (DNS rebinding).

    Args:
        handlers: Request handlers.
        names: Regular expression of the accepted host names.
        settings: Settings of the application.
    """
    application = tornado.web.Application(**settings)
    application.add_handlers(names, list(handlers))
    return application


def listen(application: tornado.web.Application, port: int | None, host: str = HOST) -> int:
    """Serve an application; return the port.

    Args:
        application: Application to serve.
        port: Port; None takes the first free one from 7000 on, 0 any.
        host: Address to listen on.

    Raises:
        ViewerError: The port is in use.
    """
    server = tornado.httpserver.HTTPServer(application)
    for candidate in range(FIRST_PORT, FIRST_PORT + _PORTS) if port is None else (port,):
        with contextlib.suppress(OSError):
            sockets = tornado.netutil.bind_sockets(candidate, host)
            server.add_sockets(sockets)
            return int(sockets[0].getsockname()[1])
    what = f"port {port} is" if port is not None else f"all ports from {FIRST_PORT} on are"
    raise ViewerError(f"{what} in use on {host}; give another port, or port=0 for any")

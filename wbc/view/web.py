"""Serves pages: their files, their port, a check of the host name, and the frames of a scene."""

from __future__ import annotations

import contextlib
import errno
import hmac
import json
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import tornado.httpserver
import tornado.netutil
import tornado.web
import tornado.websocket

from wbc.view.errors import ViewerError
from wbc.view.page_text import served_page

if TYPE_CHECKING:
    from wbc.view.scene import Scene

HOST = "127.0.0.1"
LOOPBACK = r"(127\.0\.0\.1|localhost)"
FIRST_PORT = 7000
_PORTS = 200
_STILL = 1e-5  # m or 1; smaller changes of a pose are not sent
_KINDS = {".css": "text/css", ".js": "text/javascript"}


#: Pages load nothing from elsewhere, and no other page may put them into a frame.
_POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-inline'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self' data: blob:; worker-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class GuardedHandler(tornado.web.RequestHandler):
    """A handler that refuses requests without the token of the server, if that has one.

    The address that the server prints contains the token. Its page keeps it in a cookie, for its
    scripts and web sockets.
    """

    def set_default_headers(self) -> None:
        self.set_header("Content-Security-Policy", _POLICY)
        self.set_header("X-Frame-Options", "DENY")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")

    def prepare(self) -> None:
        token: str = self.settings.get("token", "")
        if not token:
            return
        cookie = f"wbc_{self.settings['port']}"
        given = self.get_query_argument("token", "")
        if hmac.compare_digest(given.encode(), token.encode()):
            self.set_cookie(cookie, token, httponly=True, samesite="Strict")
        elif not hmac.compare_digest((self.get_cookie(cookie) or "").encode(), token.encode()):
            self.set_status(403)
            self.finish("Open the address that wbc printed: it contains a token.")


class Text(GuardedHandler):
    """The handler of a page, a script or a style sheet."""

    def initialize(self, text: str, kind: str) -> None:
        self.text, self.kind = text, kind

    def get(self) -> None:
        self.set_header("Content-Type", f"{self.kind}; charset=utf-8")
        self.set_header("Cache-Control", "no-store")
        self.finish(self.text)


class ScenePage(GuardedHandler, tornado.websocket.WebSocketHandler):
    """The web socket of a page that shows a scene: its objects first, then frames."""

    async def send_objects(self, scene: Scene, commands: Iterable[bytes], **more: object) -> None:
        """Send the commands that create the objects, then the paths of the nodes and `more`."""
        self.set_nodelay(True)
        self._sent = np.full_like(scene.poses, np.inf)
        with contextlib.suppress(tornado.websocket.WebSocketClosedError):
            await self.write_message(json.dumps({"scale": scene.proportions.top}))
            for command in commands:
                await self.write_message(command, binary=True)
            await self.write_message(json.dumps({"paths": scene.paths, **more}))

    def send_frame(self, scene: Scene, caption: dict[str, Any]) -> None:
        """Send a caption and the poses that have changed since the last frame."""
        changed = np.flatnonzero(np.abs(scene.poses - self._sent).max(axis=1) > _STILL)
        self._sent = scene.poses.copy()
        poses = np.round(scene.poses[changed], 5).ravel().tolist()
        self.send({"caption": caption, "nodes": changed.tolist(), "poses": poses})

    def send(self, message: dict[str, Any]) -> None:
        """Send a message as JSON, unless the page is closed."""
        with contextlib.suppress(tornado.websocket.WebSocketClosedError):
            self.write_message(json.dumps(message, separators=(",", ":")))


def page_handlers(name: str, files: Sequence[Path]) -> list[Any]:
    """Return the handlers of a page and its files.

    Args:
        name: Name of the robot.
        files: Paths of its scripts and style sheets.
    """
    texts = {path.name: (path.read_text("utf-8"), _KINDS[path.suffix]) for path in files}
    texts[""] = served_page(name, files), "text/html"
    return [
        (rf"/(?:static/)?{re.escape(route)}", Text, {"text": text, "kind": kind})
        for route, (text, kind) in texts.items()
    ]


def listen(
    handlers: Sequence[Any],
    port: int | None,
    host: str = HOST,
    names: str = LOOPBACK,
    token: str = "",
    **settings: Any,
) -> int:
    """Serve an application that rejects requests for other host names; return the port.

    Otherwise the pages of another site could reach it under a name that resolves to this machine
    (DNS rebinding).

    Args:
        handlers: Request handlers.
        port: Port; None takes the first free one from 7000 on, 0 any.
        host: Address to listen on.
        names: Regular expression of the accepted host names.
        token: What the address must contain; anybody may open the page if it is empty.
        settings: Settings of the application.

    Raises:
        ViewerError: The port is in use, or the system refuses the address or port.
    """
    application = tornado.web.Application(log_function=lambda _: None, **settings)
    application.add_handlers(names, list(handlers))
    server = tornado.httpserver.HTTPServer(application)
    for candidate in range(FIRST_PORT, FIRST_PORT + _PORTS) if port is None else (port,):
        try:
            sockets = tornado.netutil.bind_sockets(candidate, host)
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                text = f"cannot listen on {host}, port {candidate}: {error.strerror}"
                raise ViewerError(f"{text}; give another address or port") from error
            continue
        bound = int(sockets[0].getsockname()[1])
        application.settings.update(token=token, port=bound)
        server.add_sockets(sockets)
        return bound
    what = f"port {port} is" if port is not None else f"all ports from {FIRST_PORT} on are"
    raise ViewerError(f"{what} in use on {host}; give another port, or port=0 for any")

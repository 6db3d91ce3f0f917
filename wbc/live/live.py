"""`Live`: a page that shows and drives a robot in a running loop, served by another process."""

from __future__ import annotations

import logging
import secrets
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import numpy as np

from wbc.live.address import is_local, needs_token
from wbc.live.config import LiveServerConfig
from wbc.live.errors import LiveError
from wbc.process import ChildProcess
from wbc.runtime.controller_inputs import controller_inputs
from wbc.runtime.event_queue import EventQueue
from wbc.runtime.process_observer import ProcessObserver
from wbc.teleop import CommandHandler
from wbc.view.terrain import checked_boxes

if TYPE_CHECKING:
    from wbc.runtime.event import RunEvent
    from wbc.runtime.schema import Quantity

logger = logging.getLogger(__name__)

_OPEN = (
    "the page is open to the network, without encryption: whoever has its address drives the robot"
)
_RATE = 40.0  # Hz of frames and status


class Live(ProcessObserver):
    """Serves a page that shows a robot and sends commands to it.

    Another process reads the loop's ticks from shared memory and serves the page. The loop never
    waits for it, and continues if it ends.

    Example:
        >>> with CommandHandler(player, plant) as handler, Live(handler) as live:
        ...     wbc.teleop.run(handler, 3600.0, clients=[live])

    Args:
        handler: Handler that receives the page's commands.
        host: Address to listen on; by default only this machine can reach the page.
        port: Port of the page; None takes the first free one from 7000 on, 0 any free one.
        boxes: Terrain as upright boxes: centre, then half sizes, m, shape (n, 6).
        announce: Whether to print the page's address.
        token: What the address of the page must contain, so that nobody else drives the robot;
            by default random where others could reach the page, over the network or as users of
            this machine, and empty elsewhere.
        uploads: Folder for the files that pages send, and that are saved for them; by default one
            that is removed at the end.
        notice: What the pages show at first; empty for nothing.

    Attributes:
        reset_hint: How a person resets the robot on the page.
        url: Address of the page.
        port: Port of the page.
        token: See above.
        stream: Stream that the page reads, see `wbc.runtime.protocols.StreamObserver`.

    Raises:
        LiveError: The page cannot be served.
    """

    reset_hint = "press Reset (R) on the page"

    def __init__(
        self,
        handler: CommandHandler,
        *,
        host: str = "127.0.0.1",
        port: int | None = None,
        boxes: np.ndarray | None = None,
        announce: bool = True,
        token: str | None = None,
        uploads: Path | None = None,
        notice: str = "",
    ) -> None:
        if token is None:
            token = secrets.token_urlsafe(16) if needs_token(host) else ""
        self.token = token
        self._own_uploads = tempfile.TemporaryDirectory(prefix="wbc-") if uploads is None else None
        folder = uploads if self._own_uploads is None else Path(self._own_uploads.name)
        assert folder is not None
        robot = handler.player.robot
        self._handler = handler
        channel = handler.open_channel().config
        self._events = EventQueue()
        config = LiveServerConfig(
            robot, port, _RATE, checked_boxes(boxes), channel, host, token, handler.player.dt,
            self._events.descriptor, folder, notice,
        )  # fmt: skip
        descriptors = (*channel.descriptors, self._events.descriptor)
        super().__init__(ChildProcess("wbc.live.server", descriptors, title="the live page"))
        self.url = str(self._configure(config, LiveError, "the live page: ")["url"])
        self.port = int(urlsplit(self.url).port or 0)
        if announce:
            print(f"Live: {self.url}", flush=True)
            if not is_local(host):
                logger.warning(_OPEN)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Quantities of the command handler, and what ticks are explained from.

        See `wbc.runtime.protocols.StreamObserver`.
        """
        return (*self._handler.quantities, controller_inputs(self._handler.player.robot))

    def on_event(self, event: RunEvent) -> None:
        """Show an event of the run; see `wbc.runtime.event.EventObserver`."""
        self._events.put(1 if self.stream is None else self.stream.runs, event)

    def close(self) -> None:
        """End the process."""
        super().close()
        self._events.close()
        if self._own_uploads is not None:
            self._own_uploads.cleanup()

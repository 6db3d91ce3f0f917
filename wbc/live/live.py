"""`Live`: a page that shows and drives a robot in a running loop, served by another process."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING

import numpy as np

from wbc.closeable import Closeable
from wbc.live.config import LiveServerConfig
from wbc.live.errors import LiveError
from wbc.process import ChildProcess, ProcessStartError
from wbc.teleop import CommandHandler
from wbc.view.terrain import checked_boxes

if TYPE_CHECKING:
    from wbc.runtime.protocols import Controller, Plant
    from wbc.runtime.report import Report
    from wbc.runtime.schema import Quantity
    from wbc.runtime.stream import TickStream
    from wbc.runtime.tick import Tick

_RATE = 40.0  # Hz of frames and status


class Live(Closeable):
    """Serves a page that shows a robot and sends commands to it.

    The page is served by another process, which reads the loop's ticks from shared memory. The
    loop never waits, and goes on when the other process has died.

    Example:
        >>> with CommandHandler(player, plant) as handler, Live(handler) as live:
        ...     wbc.teleop.run(handler, 3600.0, clients=[live])

    Args:
        handler: takes the page's commands.
        host: address to listen on; by default only this machine can reach the page.
        port: None takes the first free one from 7000 on, 0 any free one.
        boxes: (n, 6) terrain, upright boxes: centre, then half sizes, m.
        announce: print the page's address.

    Attributes:
        reset_hint: how a person resets the robot on the page.
        url: address of the page.
        stream: from which the page reads, see `wbc.runtime.protocols.StreamObserver`.

    Raises:
        LiveError: the page cannot be served.
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
    ) -> None:
        robot = handler.player.robot
        self._handler = handler
        self.stream: TickStream | None = None
        channel = handler.open_channel().config
        self._process = ChildProcess("wbc.live.server", channel.descriptors, title="the live page")
        config = LiveServerConfig(
            robot=robot,
            boxes=checked_boxes(boxes),
            channel=channel,
            host=host,
            port=port,
            rate=_RATE,
            parent=os.getpid(),
        )
        try:
            self.url = str(self._process.configure(config)["url"])
        except BaseException as error:
            self.close()
            if isinstance(error, ProcessStartError):
                raise LiveError(f"the live page: {error}") from error
            raise
        if announce:
            print(f"Live: {self.url}", flush=True)

    @property
    def alive(self) -> bool:
        """Whether the page's process runs."""
        return self._process.alive

    @property
    def pid(self) -> int:
        """Process id of the page's process."""
        return self._process.pid

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Those of the command handler; see `wbc.runtime.protocols.StreamObserver`."""
        return self._handler.quantities

    def attach(self, stream: TickStream) -> None:
        """Read from a stream from now on; see `wbc.runtime.protocols.StreamObserver`."""
        self.stream = stream
        self._process.send(*stream.link())

    def begin(self, controller: Controller, plant: Plant) -> None:
        """Do nothing; see `wbc.runtime.protocols.Observer`."""

    def observe(self, tick: Tick) -> None:
        """Warn if the page's process has ended. The page gets the tick from the stream."""
        self._process.warn_if_exited(time.perf_counter())

    def end(self, report: Report) -> None:
        """Do nothing; see `wbc.runtime.protocols.Observer`."""

    def close(self) -> None:
        """End the page's process."""
        self._process.close()

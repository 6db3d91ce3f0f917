"""`Live`: a page that shows and drives a robot in a running loop, served by another process."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from wbc.live.config import LiveServerConfig
from wbc.live.errors import LiveError
from wbc.process import ChildProcess
from wbc.runtime.process_observer import ProcessObserver
from wbc.teleop import CommandHandler
from wbc.view.terrain import checked_boxes

if TYPE_CHECKING:
    from wbc.runtime.schema import Quantity

_RATE = 40.0  # Hz of frames and status


class Live(ProcessObserver):
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
        channel = handler.open_channel().config
        config = LiveServerConfig(
            robot=robot,
            boxes=checked_boxes(boxes),
            channel=channel,
            host=host,
            port=port,
            rate=_RATE,
            parent=os.getpid(),
        )
        super().__init__(
            ChildProcess("wbc.live.server", channel.descriptors, title="the live page")
        )
        self.url = str(self._configure(config, LiveError, "the live page: ")["url"])
        if announce:
            print(f"Live: {self.url}", flush=True)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Those of the command handler; see `wbc.runtime.protocols.StreamObserver`."""
        return self._handler.quantities

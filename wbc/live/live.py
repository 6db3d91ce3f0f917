"""`Live`: a page that shows and drives a robot in a running loop, served by another process."""

from __future__ import annotations

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

    Attributes:
        reset_hint: How a person resets the robot on the page.
        url: Address of the page.
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
    ) -> None:
        robot = handler.player.robot
        self._handler = handler
        channel = handler.open_channel().config
        config = LiveServerConfig(robot, port, _RATE, checked_boxes(boxes), channel, host)
        super().__init__(
            ChildProcess("wbc.live.server", channel.descriptors, title="the live page")
        )
        self.url = str(self._configure(config, LiveError, "the live page: ")["url"])
        if announce:
            print(f"Live: {self.url}", flush=True)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Quantities of the command handler; see `wbc.runtime.protocols.StreamObserver`."""
        return self._handler.quantities

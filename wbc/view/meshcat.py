"""`Meshcat`: a live view of a run in a browser, from a process of its own."""

from __future__ import annotations

import time
import webbrowser
from typing import TYPE_CHECKING

import numpy as np

from wbc.errors import StateError
from wbc.process import ChildProcess
from wbc.runtime.process_observer import ProcessObserver
from wbc.runtime.schema import SchemaError
from wbc.runtime.snapshot import Snapshot
from wbc.runtime.stream import TickStream
from wbc.view.config import ViewerConfig
from wbc.view.errors import ViewerError
from wbc.view.terrain import checked_boxes

if TYPE_CHECKING:
    from wbc.robot import Robot


class Meshcat(ProcessObserver):
    """Shows a robot in a browser while a loop runs.

    Another process reads the loop's ticks from shared memory and serves the page. A slow,
    stopped or terminated viewer process does not affect the loop.

    Args:
        robot: Robot to show.
        port: Port of the page on this machine; None takes the first free one from 7000 on, 0 any
            free one.
        rate: Frame rate, Hz.
        open: Whether to open the page in the browser.
        boxes: Terrain as boxes: see `wbc.sim.Terrain`.
        announce: Whether to print the page's address.

    Attributes:
        url: Address of the page, which is served to this machine only.
        stream: Stream that the viewer reads, see `wbc.runtime.protocols.StreamObserver`.

    Raises:
        ViewerError: The process does not start, the port is in use, or `rate` or `boxes` is
            invalid.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        port: int | None = None,
        rate: float = 30.0,
        open: bool = False,
        boxes: np.ndarray | None = None,
        announce: bool = True,
    ) -> None:
        if not rate > 0.0:
            raise ViewerError(f"rate is {rate} Hz; a viewer needs a positive one")
        from wbc.robot import checked_robot

        self._robot = checked_robot(robot, "Meshcat")
        config = ViewerConfig(robot, port, float(rate), checked_boxes(boxes))
        super().__init__(ChildProcess("wbc.view.server", title="the viewer"))
        self.url = str(self._configure(config, ViewerError, "the viewer: ")["url"])
        if announce:
            print(f"Viewer: {self.url}", flush=True)
        if open:
            webbrowser.open(self.url)

    def attach(self, stream: TickStream) -> None:
        """Read a stream from now on; see `wbc.runtime.protocols.StreamObserver`.

        Raises:
            ViewerError: The stream is of a robot with a different number of joints.
        """
        if stream.robot.nq != self._robot.nq:
            raise ViewerError(
                f"the viewer draws '{self._robot.name}', the loop runs '{stream.robot.name}'; "
                "make the viewer with the plant's robot"
            )
        super().attach(stream)

    def show(self, snapshot: Snapshot) -> None:
        """Show a snapshot outside a loop, without waiting for the viewer's process.

        Raises:
            StateError: `snapshot.q` has the wrong size.
            ViewerError: Another part of the snapshot has the wrong shape.
        """
        robot = self._robot
        if np.shape(snapshot.q) != (robot.nq,):
            raise StateError(
                f"snapshot.q has shape {np.shape(snapshot.q)}, the model needs ({robot.nq},)"
            )
        if self.stream is None:
            self.attach(TickStream(robot, capacity=8))
        assert self.stream is not None
        try:
            self.stream.write(snapshot.to_tick(robot))
        except SchemaError as error:
            raise ViewerError(
                f"the snapshot at {snapshot.time} s cannot be shown: {error}"
            ) from error
        self._process.warn_if_exited(time.perf_counter())

"""`Meshcat`: a live view of a run in a browser, from a process of its own."""

from __future__ import annotations

import os
import time
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wbc.closeable import Closeable
from wbc.process import ChildProcess, ProcessStartError
from wbc.runtime.snapshot import Snapshot
from wbc.view.due import next_due
from wbc.view.errors import ViewerError
from wbc.view.order import Order
from wbc.view.recording import Recording
from wbc.view.ring import Ring
from wbc.view.slot import Layout
from wbc.view.terrain import checked_boxes

if TYPE_CHECKING:
    from wbc.robot import Robot


class Meshcat(Closeable):
    """Shows a robot in a browser while a loop runs.

    The loop's process only copies a snapshot into shared memory, some
    microseconds; everything else happens in another process, which may be slow,
    stopped or dead without any harm to the loop.

    Args:
        robot: the robot.
        port: of the page on this machine; None takes the first free one from
            7000 on, 0 any free one.
        rate: frames per second, Hz.
        record: also make a recording, written to this path when the viewer closes.
        open: open the page in the browser.
        boxes: (n, 6) terrain, upright boxes: centre, then half sizes, m.
        announce: print the page's address.

    Attributes:
        url: address of the page; it answers on this machine only.

    Raises:
        ViewerError: the process does not start, the port is taken, or `rate` or `boxes` make no
            sense.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        port: int | None = None,
        rate: float = 30.0,
        record: str | Path | None = None,
        open: bool = False,
        boxes: np.ndarray | None = None,
        announce: bool = True,
    ) -> None:
        if not rate > 0.0:
            raise ViewerError(f"rate is {rate} Hz; a viewer needs a positive one")
        self.rate = float(rate)
        self._ring = Ring(Layout.of(robot.model))
        self._record = Path(record) if record is not None else None
        self._recording = Recording(robot, boxes=boxes) if record is not None else None
        self._due = 0.0
        self._process = ChildProcess(
            "wbc.view.server", (self._ring.descriptor,), title="the viewer"
        )
        order = Order(
            robot,
            self._ring.descriptor,
            port,
            self.rate,
            checked_boxes(boxes),
            os.getpid(),
        )
        try:
            self.url = str(self._process.configure(order)["url"])
        except BaseException as error:
            self.close()
            if isinstance(error, ProcessStartError):
                raise ViewerError(f"the viewer: {error}") from error
            raise
        if announce:
            print(f"Viewer: {self.url}", flush=True)
        if open:
            webbrowser.open(self.url)

    @property
    def alive(self) -> bool:
        """Whether the viewer's process is there."""
        return self._process.alive

    @property
    def pid(self) -> int:
        """Of the viewer's process."""
        return self._process.pid

    def due(self, now: float) -> bool:
        """Whether showing something now would be seen.

        A fast loop asks this first, and saves itself the making of a snapshot.

        Args:
            now: the run's own time, s.
        """
        if self._recording is not None and self._recording.due(now):
            return True
        return time.perf_counter() >= self._due

    def show(self, snapshot: Snapshot) -> None:
        """Show a snapshot. Never waits; whatever happens to the viewer, returns.

        Raises:
            StateError: `snapshot.q` has the wrong size.
            ViewerError: another part of it has the wrong shape.
        """
        now = time.perf_counter()
        if now >= self._due:
            self._due = next_due(self._due, now, 1.0 / self.rate)
        self._ring.write(snapshot)
        if self._recording is not None:
            self._recording.show(snapshot)
        self._process.warn_if_exited(now)

    def close(self) -> None:
        """End the viewer's process, and write the recording if there is one."""
        self._process.close()
        self._ring.close()
        recording, self._recording = self._recording, None
        if recording is not None and self._record is not None and len(recording):
            recording.save(self._record)

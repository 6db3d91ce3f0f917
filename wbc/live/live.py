"""`Live`: a page that shows and drives a robot in a running loop, served by another process."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING

import numpy as np

from wbc.closeable import Closeable
from wbc.live.config import LiveServerConfig
from wbc.live.errors import LiveError
from wbc.live.gauges import NO_MOTION, RETURNING, SIZE
from wbc.process import ChildProcess, ProcessStartError, RecordRing
from wbc.runtime.mode import Mode
from wbc.runtime.snapshot import Snapshot
from wbc.teleop import CommandHandler
from wbc.view.due import next_due
from wbc.view.ring import Ring
from wbc.view.slot import Layout
from wbc.view.terrain import checked_boxes

if TYPE_CHECKING:
    from wbc.runtime.protocols import Controller, Plant
    from wbc.runtime.report import Report
    from wbc.runtime.tick import Tick

_RATE = 40.0  # Hz of snapshots
_STATUS_RATE = 100.0  # Hz of the live status; each has the largest values since the last
_NOTE_DURATION = 8.0  # s of plant time for which a motion's note is shown


class Live(Closeable):
    """Serves a page that shows a robot and sends commands to it.

    The page is served by another process. The loop's process copies the status and snapshots of
    some ticks into shared memory; it never waits, and goes on when the other process has died.

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
        self._handler, self._player = handler, handler.player
        robot = self._player.robot
        self._snapshots = Ring(Layout.of(robot.model))
        self._gauges = RecordRing(SIZE)
        self._run = 0
        self._due = self._gauges_due = self._note_end = 0.0
        self._worst_error = self._worst_time = 0.0  # since the last status
        self._notes = 0
        self._last = np.zeros(SIZE)
        channel = handler.open_channel().config
        self._shared = (self._snapshots, self._gauges)
        descriptors = [*channel.descriptors, *(memory.descriptor for memory in self._shared)]
        self._process = ChildProcess("wbc.live.server", descriptors, title="the live page")
        config = LiveServerConfig(
            robot=robot,
            boxes=checked_boxes(boxes),
            channel=channel,
            host=host,
            port=port,
            rate=_RATE,
            snapshots=self._snapshots.descriptor,
            gauges=self._gauges.descriptor,
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

    def begin(self, controller: Controller, plant: Plant) -> None:
        """A run begins, see `wbc.runtime.protocols.Recorder`."""
        self._run += 1
        self._notes = 0
        self._due = self._gauges_due = 0.0  # a run that begins paused shows its first tick
        self._worst_error = self._worst_time = 0.0

    def record(self, tick: Tick, controller: Controller) -> None:
        """Show a tick. Never waits; whatever happens to the page, returns."""
        self._worst_error = max(self._worst_error, self._player.dcm_error)
        self._worst_time = max(self._worst_time, tick.estimator_time + tick.controller_time)
        now = time.perf_counter()
        if now >= self._gauges_due:
            self._gauges_due = next_due(self._gauges_due, now, 1.0 / _STATUS_RATE)
            self._show_status(tick.time)
            self._process.warn_if_exited(now)
        if now >= self._due:
            self._due = next_due(self._due, now, 1.0 / _RATE)
            self._snapshots.write(Snapshot.of(tick, self._player, self._activity(tick.time)))

    def _show_status(self, time: float) -> None:
        pushes = self._handler.pushes
        record = self._gauges.begin()
        record[:] = (
            time,
            Mode.RUNNING,
            self._worst_error,
            self._worst_time,
            *self._player.velocity,
            self._playing(),
            pushes.decided,
            pushes.survived,
            self._run,
        )
        self._gauges.publish()
        self._last = record
        self._worst_error = self._worst_time = 0.0

    def _playing(self) -> int:
        playing = self._player.playing
        if playing is not None:
            return self._handler.capabilities.motions.index(type(playing))
        return NO_MOTION if self._player.idle else RETURNING

    def _activity(self, now: float) -> str:
        """Return the line of text below the robot's name."""
        playing = self._player.playing
        if playing is not None:
            return playing.name
        notes = self._player.context.notes
        if len(notes) != self._notes:
            self._notes, self._note_end = len(notes), now + _NOTE_DURATION
        if notes and now < self._note_end:
            return notes[-1]
        return "" if self._player.idle else "returning to standing"

    def end(self, report: Report) -> None:
        """The run is over, see `wbc.runtime.protocols.Recorder`."""

    def idle(self, mode: Mode) -> None:
        """Tell the page that there are no ticks: the loop is paused, or the robot has fallen."""
        pushes = self._handler.pushes
        last = self._last.copy()
        record = self._gauges.begin()
        record[:] = last
        record[1] = mode
        record[-3:] = (pushes.decided, pushes.survived, self._run)
        self._gauges.publish()
        self._last = record

    def close(self) -> None:
        """End the page's process."""
        self._process.close()
        for memory in self._shared:
            memory.close()

"""`Live`: a page that drives a robot in a running loop, from a process of its own."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.closeable import Closeable
from wbc.live.errors import LiveError
from wbc.live.gauges import SIZE, Mode
from wbc.live.helm import RETURNING, Helm
from wbc.live.order import Order
from wbc.motions import Motion, MotionPlayer
from wbc.motions.engine.packing import check_importable
from wbc.motions.registry import MOTIONS
from wbc.process import ChildProcess, ProcessStartError, RecordRing
from wbc.runtime.snapshot import Snapshot
from wbc.view.due import next_due
from wbc.view.ring import Ring
from wbc.view.slot import Layout
from wbc.view.terrain import checked_boxes

if TYPE_CHECKING:
    from wbc.runtime.protocols import Controller, Plant
    from wbc.runtime.report import Report
    from wbc.runtime.tick import Tick

_RATE = 40.0  # Hz of snapshots
_GAUGES = 100.0  # Hz of the figures; each tells of the worst tick since the last
_NOTED = 8.0  # s of plant time: how long a motion's note is shown


class Live(Closeable):
    """Serves a page that shows a robot and drives it.

    The page and everything about it live in another process. The loop's process copies figures
    and snapshots of some ticks into shared memory, and looks there for requests before each
    tick; it never waits, and goes on when the other process has died.

    Example:
        >>> with Live(player, plant) as live:
        ...     drive(live, player, plant, 3600.0)

    Args:
        player: whom to drive.
        plant: what it is in; it may have `push` and `reset`.
        host: address to listen on; by default only this machine can reach the page.
        port: None takes the first free one from 7000 on, 0 any free one.
        boxes: (n, 6) terrain, upright boxes: centre, then half sizes, m.
        motions: that get a button; the whole catalogue when left out.
        announce: print the page's address.

    Attributes:
        helm: takes requests; `before_tick` of `wbc.run`.
        paces: the helm does: the loop's own clock would not know slow motion.
        rescue: how a robot that fell is set on its feet.
        url: address of the page.

    Raises:
        LiveError: the page cannot be served.
        MotionError: a motion is not at the top of a module.
    """

    paces = True
    rescue = "Reset on the page sets it on its feet"

    def __init__(
        self,
        player: MotionPlayer,
        plant: Any,
        *,
        host: str = "127.0.0.1",
        port: int | None = None,
        boxes: np.ndarray | None = None,
        motions: Sequence[type[Motion]] = MOTIONS,
        announce: bool = True,
    ) -> None:
        for motion in motions:
            check_importable(motion)
        robot = player.robot
        self._performer, self._plant = player, plant
        self._snapshots = Ring(Layout.of(robot.model))
        self._gauges = RecordRing(SIZE)
        self.helm = Helm(player, plant, motions, self._idle)
        self._mode = Mode.RUNNING
        self._run = 0
        self._due = self._gauges_due = self._noted_until = 0.0
        self._worst_error = self._worst_time = 0.0  # since the figures were shown
        self._notes = 0
        self._last = np.zeros(SIZE)
        self._shared = (self._snapshots, self._gauges, self.helm.requests, self.helm.shelf)
        descriptors = [memory.descriptor for memory in self._shared]
        self._process = ChildProcess("wbc.live.server", descriptors, title="the live page")
        order = Order(
            robot=robot,
            boxes=checked_boxes(boxes),
            panel=self.helm.panel,
            host=host,
            port=port,
            rate=_RATE,
            snapshots=self._snapshots.descriptor,
            gauges=self._gauges.descriptor,
            requests=self.helm.requests.descriptor,
            shelf=self.helm.shelf.descriptor,
            parent=os.getpid(),
        )
        try:
            self.url = str(self._process.configure(order)["url"])
        except BaseException as error:
            self.close()
            if isinstance(error, ProcessStartError):
                raise LiveError(f"the live page: {error}") from error
            raise
        if announce:
            print(f"Live: {self.url}", flush=True)

    @property
    def alive(self) -> bool:
        """Whether the page's process is there."""
        return self._process.alive

    @property
    def pid(self) -> int:
        """Of the page's process."""
        return self._process.pid

    def begin(self, controller: Controller, plant: Plant) -> None:
        """A run begins, see `wbc.runtime.protocols.Recorder`."""
        self._run += 1
        self._mode = Mode.RUNNING
        self._notes = 0
        self._due = self._gauges_due = 0.0  # a run that begins paused shows its first tick
        self._worst_error = self._worst_time = 0.0
        self.helm.begin()

    def record(self, tick: Tick, controller: Controller) -> None:
        """Show a tick. Never waits; whatever happens to the page, returns."""
        self._worst_error = max(self._worst_error, self._performer.dcm_error)
        self._worst_time = max(self._worst_time, tick.estimator_time + tick.controller_time)
        now = time.perf_counter()
        if now >= self._gauges_due:
            self._gauges_due = next_due(self._gauges_due, now, 1.0 / _GAUGES)
            self._gauge(tick.time)
            self._process.warn_if_exited(now)
        if now >= self._due:
            self._due = next_due(self._due, now, 1.0 / _RATE)
            doing = self._doing(tick.time)
            self._snapshots.write(Snapshot.of(tick, self._performer, doing))

    def _gauge(self, time: float) -> None:
        helm = self.helm
        record = self._gauges.begin()
        record[:] = (
            time,
            Mode.RUNNING,
            self._worst_error,
            self._worst_time,
            *self._performer.velocity,
            helm.playing,
            helm.pushes.decided,
            helm.pushes.survived,
            helm.taken,
            self._run,
        )
        self._gauges.publish()
        self._last = record
        self._worst_error = self._worst_time = 0.0

    def _doing(self, now: float) -> str:
        playing = self.helm.playing
        if playing >= 0:
            return self.helm.panel.motions[playing].name
        notes = self._performer.context.notes
        if len(notes) != self._notes:
            self._notes, self._noted_until = len(notes), now + _NOTED
        if notes and now < self._noted_until:
            return notes[-1]
        return "back to standing" if playing == RETURNING else ""

    def end(self, report: Report) -> None:
        """The run is over, see `wbc.runtime.protocols.Recorder`."""

    @property
    def reset_wanted(self) -> bool:
        """Whether a reset has been asked for since the run began."""
        return self.helm.reset_wanted

    def heed(self, stop: Callable[[], bool]) -> None:
        """Ask this while it is paused: whether to end the run."""
        self.helm.stop = stop

    def lie(self) -> None:
        """It fell: say so to the page, and look whether a reset is wanted."""
        if self._mode is not Mode.FALLEN:
            self._mode = Mode.FALLEN
            self.helm.pushes.fell()
        self.helm.lie()

    def _idle(self) -> None:
        """While nothing moves, the page is told so, and that requests are taken."""
        helm = self.helm
        last = self._last.copy()
        record = self._gauges.begin()
        record[:] = last
        record[1] = Mode.PAUSED if self._mode is Mode.RUNNING else self._mode
        record[-4:] = (helm.pushes.decided, helm.pushes.survived, helm.taken, self._run)
        self._gauges.publish()
        self._last = record

    def close(self) -> None:
        """End the page."""
        self._process.close()
        for memory in self._shared:
            memory.close()

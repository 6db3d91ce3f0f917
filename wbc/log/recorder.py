"""`FlightRecorder`: a log of every tick, written by a process of its own."""

from __future__ import annotations

import logging
import shutil
import time
from pathlib import Path
from typing import TYPE_CHECKING

from wbc.log.config import LogConfig
from wbc.log.errors import LogError, require_packages
from wbc.log.metadata import Metadata, run_metadata
from wbc.log.previous_log import PreviousLog
from wbc.log.recovery import complete
from wbc.log.status import LogStatus
from wbc.process import ChildProcess
from wbc.runtime.controller_inputs import controller_inputs
from wbc.runtime.event_queue import EventQueue
from wbc.runtime.process_observer import ProcessObserver

if TYPE_CHECKING:
    from wbc.robot import Robot
    from wbc.runtime.event import RunEvent
    from wbc.runtime.protocols import Controller, Plant
    from wbc.runtime.report import Report
    from wbc.runtime.schema import Quantity
    from wbc.runtime.stream import TickStream
    from wbc.runtime.tick import Tick

logger = logging.getLogger(__name__)

_CHECK_PERIOD = 0.5  # s, between two checks that the process still writes
_LOW_SPACE = 500e6  # bytes
_LOG_RATE = 1.5e6  # bytes/s, Talos at 500 Hz
_GRACE = 20.0  # s, for the process to write the remaining ticks and end


class FlightRecorder(ProcessObserver):
    """Records every tick of a run in an MCAP file of ROS 2 messages.

    Another process reads the ticks from shared memory, encodes them as messages and writes them in
    chunks, two per second: if a process is killed, at most the last second of the log is lost.
    When the disk is full, the log ends and the run continues.

    Example:
        >>> with FlightRecorder("walk.mcap", robot) as log:
        ...     wbc.run(walker, plant, 10.0, observers=[log])

    Args:
        path: Path of the file. An existing file is kept as `NAME.previous.mcap` until the new one
            is complete.
        robot: Robot of the run.

    Attributes:
        path: Path of the file.
        stream: Stream that the ticks are read from, see
            `wbc.runtime.protocols.StreamObserver`.

    Raises:
        MissingExtra: `mcap` or `rosbags` is not installed.
        LogError: The file cannot be written, or the process does not start.
    """

    def __init__(self, path: str | Path, robot: Robot) -> None:
        require_packages()
        self.path = Path(path)
        self._robot = robot
        self._status = LogStatus()
        self._events = EventQueue()
        self._run = 0
        self._observed = 0
        self._next_check = 0.0
        self._warned = self._closed = self._configured = False
        descriptors = (self._status.descriptor, self._events.descriptor)
        config = LogConfig(robot, self.path, *descriptors)
        super().__init__(ChildProcess("wbc.log.writer", descriptors, _GRACE))
        self._previous = PreviousLog(self.path)
        try:
            self._configure(config, LogError, f"the log {self.path}: ")
        except BaseException:
            self._previous.restore()
            raise
        self._configured = True
        self._warn_if_disk_is_nearly_full()

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What ticks are solved again from, see `LoggedTick`."""
        return (controller_inputs(self._robot),)

    @property
    def alive(self) -> bool:
        """Whether ticks are still being logged."""
        return not self._status.reason and self._process.alive

    @property
    def dropped(self) -> int:
        """Number of ticks so far that the log lacks because the log writer was too slow."""
        return self._status.dropped

    def attach(self, stream: TickStream) -> None:
        """Read a stream from now on; see `wbc.runtime.protocols.StreamObserver`.

        Raises:
            LogError: The stream is of another robot.
        """
        if stream.robot.joint_names != self._robot.joint_names:
            raise LogError(
                f"the log is of '{self._robot.name}', the loop runs '{stream.robot.name}'; "
                "make the log with the plant's robot"
            )
        super().attach(stream)

    def begin(self, controller: Controller, plant: Plant) -> None:
        """Log the parameters of the run; see `wbc.runtime.protocols.Observer`."""
        self._run = 1 if self.stream is None else self.stream.runs
        self._process.send(run_metadata(controller, plant))

    def observe(self, tick: Tick) -> None:
        """Count the tick; the log writer reads it from the stream."""
        self._observed += not (self._warned or self._closed)
        now = time.perf_counter()
        if now >= self._next_check:
            self._next_check = now + _CHECK_PERIOD
            self._warn_if_ended()

    def on_event(self, event: RunEvent) -> None:
        """Log an event of the run; see `wbc.runtime.event.EventObserver`."""
        self._events.put(self._run, event)

    def _warn_if_disk_is_nearly_full(self) -> None:
        free = shutil.disk_usage(self.path.resolve().parent).free
        if free < _LOW_SPACE:
            logger.warning(
                "the log %s has %.0f MB left on its disk: about %.0f s of Talos at 500 Hz",
                self.path,
                1e-6 * free,
                free / _LOG_RATE,
            )

    def _warn_if_ended(self) -> None:
        """Warn once when the log has ended early."""
        code = self._process.exit_code
        if self._warned or (code in (None, 0) and not self._status.reason):
            return
        self._warned = True
        reason = self._status.reason or f"its process ended (exit code {code})"
        logger.warning("the log %s ends here: %s; the run continues without it", self.path, reason)

    def end(self, report: Report) -> None:
        """Log the report of the run; see `wbc.runtime.protocols.Observer`."""
        fields = {name: str(getattr(report, name)) for name in report.__dataclass_fields__}
        self._process.send(Metadata({"report": fields}))

    def close(self) -> None:
        """Finish the file, and warn if it lacks ticks."""
        if self._closed:
            return
        self._closed = True
        self._process.close()
        if self._configured:
            self._finish()
        self._status.close()
        self._events.close()

    def _finish(self) -> None:
        """Repair the file if the log writer did not finish it, and warn of missing ticks."""
        self._warn_if_ended()
        if self._process.exit_code != 0 and not self._status.reason:
            logger.warning("the log %s now ends at %.2f s", self.path, complete(self.path))
        if self._process.exit_code == 0 and not self._status.reason:
            self._previous.remove()
        elif (kept := self._previous.kept) is not None:
            logger.warning("the log that %s had replaced is kept as %s", self.path, kept)
        if self._events.dropped:
            logger.warning("%d events are not in %s", self._events.dropped, self.path)
        if self.dropped:
            logger.warning(
                "%d of %d ticks are not in %s: the writing process was too slow",
                self.dropped,
                self._observed,
                self.path,
            )

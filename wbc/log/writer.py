"""The log writer's process: reads ticks from shared memory and writes messages to the file.

`FlightRecorder` starts it as `python -m wbc.log.writer`; see `wbc.process.child`. It finishes the
file when the parent has closed its end or has died.
"""

from __future__ import annotations

import contextlib
import os
import queue
import sys
import time

from wbc.log.config import LogConfig
from wbc.log.errors import LogError
from wbc.log.event_log import EventLog
from wbc.log.mcapfile import McapFile
from wbc.log.metadata import Metadata, versions
from wbc.log.recovery import complete
from wbc.log.robot_info import RobotInfo
from wbc.log.status import LogStatus
from wbc.process import ParentConnection
from wbc.runtime.event_queue import EventQueue
from wbc.runtime.mode import Mode
from wbc.runtime.schema import columns_to_json
from wbc.runtime.stream import TickReader
from wbc.topics import BatchMaker, StreamTopics

_PAUSE = 0.2  # s, between two polls for new ticks
_CHUNK = 0.4  # s, between the ends of two chunks
_BATCH = 256  # largest number of ticks per batch
_NICENESS = 5  # lower priority than the control loop
_DISK_ERROR = 3  # exit code


class LogWriter:
    """Writes ticks to a log file.

    Args:
        config: Configuration of the log.

    Raises:
        OSError: The file cannot be opened or written.
    """

    def __init__(self, config: LogConfig) -> None:
        robot = config.robot
        self._file = McapFile(config.path)
        info = RobotInfo.of(robot).to_json()
        self._file.add(Metadata({"versions": versions()}, {"robot.json": info}))
        self._status = LogStatus(config.status)
        self._reader = TickReader()
        self._metadata: queue.SimpleQueue[Metadata] = queue.SimpleQueue()
        self._batches = BatchMaker(robot)
        self._topics = StreamTopics(robot)
        self._events = EventLog(self._file, EventQueue(config.events).take)
        self._add_quantities()
        self._ticks = 0
        self._due = self._longest = 0.0

    def on_message(self, message: object) -> None:
        """Receive metadata or a stream from the parent process; called in another thread."""
        if isinstance(message, Metadata):
            self._metadata.put(message)
        else:
            self._reader.on_message(message)

    def advance(self) -> int:
        """Write new metadata and a batch of the new ticks; return the number of these ticks.

        Raises:
            OSError: The file cannot be written.
        """
        while not self._metadata.empty():
            self._file.add(self._metadata.get())
        records = self._reader.take(_BATCH)
        if len(records):
            if self._topics.attach(self._reader.schema):
                self._add_quantities()
            running = records[records["mode"] == Mode.RUNNING]
            batch = self._batches.batch(running)
            self._file.write(batch, self._topics.topics_of(running))
            if len(running):
                self._events.on_ticks(running, batch.stamps)
            self._ticks += len(running)
            self._status.dropped = self._reader.lost
        self._events.advance()
        start = time.monotonic()
        if start >= self._due:
            self._due = start + _CHUNK
            self._file.commit()
            self._longest = max(self._longest, time.monotonic() - start)
        return len(records)

    def _add_quantities(self) -> None:
        """Describe the quantities of the ticks."""
        columns = columns_to_json(self._topics.schema.columns)
        self._file.add(Metadata({}, {"quantities.json": columns}))

    def finish(self) -> None:
        """Write the remaining ticks and the end of the file.

        Raises:
            OSError: The file cannot be written.
        """
        while self.advance():
            pass
        self._events.finish()
        own = {
            "ticks": str(self._ticks),
            "dropped": str(self._status.dropped),
            "longest_write_s": f"{self._longest:.6f}",
            "cpu_s": f"{time.process_time():.3f}",
        }
        self._file.add(Metadata({"log": own}))
        self._file.finish()

    def give_up(self, reason: str) -> None:
        """Report that the file cannot be written any more, and leave a readable file."""
        self._status.reason = reason
        with contextlib.suppress(OSError):
            self._file.close()


def serve(parent: ParentConnection) -> int:
    """Write until the parent has ended; return the exit code."""
    config: LogConfig = parent.config
    try:
        writer = LogWriter(config)
    except OSError as error:
        parent.reply({"error": f"{error.strerror}; give another path"})
        return _DISK_ERROR
    parent.reply({"pid": os.getpid()})
    parent.listen(writer.on_message)
    try:
        while not parent.gone:
            if writer.advance() < _BATCH:
                parent.wait(_PAUSE)
        parent.wait(_PAUSE)  # the parent's last message may still be in transit
        writer.finish()
    except OSError as error:
        writer.give_up(f"{error.strerror}: {config.path}")
        with contextlib.suppress(LogError):
            complete(config.path)
        return _DISK_ERROR
    return 0


def main() -> int:
    """Write the log that the parent's configuration describes."""
    with contextlib.suppress(OSError):
        os.nice(_NICENESS)
    return serve(ParentConnection())


if __name__ == "__main__":
    sys.exit(main())

"""The log's own process: takes ticks out of shared memory, writes messages into the file.

Started by `FlightRecorder` as `python -m wbc.log.writer`. It ends, and finishes the file,
when its standard input does: a parent that dies, however it dies, leaves a whole file.
"""

from __future__ import annotations

import contextlib
import os
import queue
import sys
import time

from wbc.log.describe import Facts
from wbc.log.errors import LogError
from wbc.log.mcapfile import McapFile
from wbc.log.order import Order
from wbc.log.recovery import repair
from wbc.log.ring import TickRing
from wbc.log.topics import CommandedWrench, Topic, Tracker, topics_of
from wbc.process import parent

_PAUSE = 0.1  # s, between two looks for ticks
_CHUNK = 0.4  # s, between the ends of two chunks
_MOST = 256  # ticks at once
_NICENESS = 5  # the loop comes first
_DISK = 3  # exit code


class LogWriter:
    """Turns ticks into a file.

    Args:
        order: what to log, and where.

    Raises:
        OSError: the file cannot be opened or written.
    """

    def __init__(self, order: Order) -> None:
        self._file = McapFile(order.path)
        self._file.add(order.facts)
        self._ring = TickRing(order.layout, order.capacity, order.descriptor)
        self._tracker = Tracker(order)
        self._topics: list[Topic] = topics_of(order)
        self._contacts = 0
        self._due = self._longest = 0.0

    def advance(self) -> bool:
        """Write some of the ticks that are there; False when there is none.

        Raises:
            OSError: the disk does not take them.
        """
        ring = self._ring
        records = ring.take(_MOST)
        count = len(records)
        if count:
            names = ring.names
            for number in range(self._contacts, len(names)):
                self._topics.append(CommandedWrench(number, names[number]))
            self._contacts = len(names)
            self._file.write(self._tracker.block(records, names), self._topics)
            ring.release(count)
        start = time.monotonic()
        if start >= self._due:
            self._due = start + _CHUNK
            self._file.commit()
            self._longest = max(self._longest, time.monotonic() - start)
        return count > 0

    def add(self, facts: Facts) -> None:
        """Write down facts."""
        self._file.add(facts)

    def finish(self) -> None:
        """Write what is left, and the end of the file.

        Raises:
            OSError: the disk does not take it.
        """
        while self.advance():
            pass
        own = {
            "ticks": str(self._ring.written),
            "dropped": str(self._ring.dropped),
            "longest_write_s": f"{self._longest:.6f}",
            "cpu_s": f"{time.process_time():.3f}",
        }
        self.add(Facts({"log": own}))
        self._file.commit()
        self._file.finish()
        self._file.close()

    def give_up(self, reason: str) -> None:
        """The disk takes no more: tell the loop, and leave a file that can be read."""
        self._ring.stop(reason)
        with contextlib.suppress(OSError):
            self._file.close()


def serve(order: Order) -> int:
    """Write until the parent is gone; returns the exit code."""
    try:
        writer = LogWriter(order)
    except OSError as error:
        parent.reply({"error": f"{error.strerror}; give another path"})
        return _DISK
    parent.reply({"pid": os.getpid()})
    facts: queue.SimpleQueue[Facts] = queue.SimpleQueue()
    parent_monitor = parent.ParentMonitor(order.parent, facts.put)
    try:
        while not parent_monitor.gone:
            _write_facts(writer, facts)
            if not writer.advance():
                parent_monitor.wait(_PAUSE)
        parent_monitor.wait(_PAUSE)  # what the parent said last
        _write_facts(writer, facts)
        writer.finish()
    except OSError as error:
        writer.give_up(f"{error.strerror}: {order.path}")
        with contextlib.suppress(LogError):
            repair(order.path)
        return _DISK
    return 0


def _write_facts(writer: LogWriter, facts: queue.SimpleQueue[Facts]) -> None:
    while not facts.empty():
        writer.add(facts.get())


def main() -> int:
    """Read the order and carry it out."""
    with contextlib.suppress(OSError):
        os.nice(_NICENESS)
    return serve(parent.receive_config())


if __name__ == "__main__":
    sys.exit(main())

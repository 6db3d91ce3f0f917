"""The stream of ticks: one record per tick in shared memory, for readers in other processes."""

from __future__ import annotations

import logging
import numbers
import queue
import struct
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.errors import short_repr
from wbc.process.ring import RingReader, SharedRing
from wbc.runtime.mode import Mode
from wbc.runtime.quantities import QUANTITIES
from wbc.runtime.record import VaryingFieldsWriter
from wbc.runtime.schema import Column, Quantity, Schema, SchemaError, declared_columns
from wbc.runtime.tick import Tick

if TYPE_CHECKING:
    from wbc.robot import Robot

logger = logging.getLogger(__name__)

CAPACITY = 4096  # ticks: eight seconds at 500 Hz


@dataclass(frozen=True)
class StreamLink:
    """The data that another process needs to read a stream.

    Attributes:
        schema: schema of the records.
        capacity: capacity of the ring, records.
        first: number of the first record to read.
        descriptor: file descriptor of the ring's memory, in the process that has the link.
    """

    schema: Schema
    capacity: int
    first: int
    descriptor: int = -1


class TickStream:
    """Writes each tick as one record that any number of processes read by the names of columns.

    Args:
        robot: the robot.
        quantities: beside those of `wbc.runtime.quantities`.
        capacity: number of ticks that a reader may lag behind before it loses some.

    Attributes:
        schema: schema of the records.
        quantities: beside the library's own.

    Raises:
        SchemaError: two quantities have the same name.
    """

    def __init__(
        self, robot: Robot, quantities: Sequence[Quantity] = (), capacity: int = CAPACITY
    ) -> None:
        self.robot, self.quantities = robot, tuple(quantities)
        columns = declared_columns(robot, (*QUANTITIES, *quantities))
        self.schema = Schema(tuple(column for column, _ in columns))
        self._ring = SharedRing(self.schema.size, capacity)
        # The descriptor is closed with the stream, whose end no observer has to tell.
        self._finalizer = weakref.finalize(self, self._ring.close)
        self._runs = 0
        # A record is completed here and then copied as a whole: what changes seldom stays.
        self._words = np.full(self.schema.size, np.nan)
        self._bytes = self._words.data
        self._record = self._words.view(self.schema.dtype)
        self._varying = VaryingFieldsWriter(self._record)
        # One call reads all attributes of a kind: a call for each would take twice as long.
        paths = [(column, source) for column, source in columns if isinstance(source, str)]
        scalars = [path for column, path in paths if column.scalar]
        self._paths = paths
        self._read_numbers = attrgetter(*scalars)
        self._read_arrays = attrgetter(*(path for column, path in paths if not column.scalar))
        self._numbers = struct.Struct(f"={len(scalars)}d")
        end = sum(column.size for column, _ in paths)
        self._array_words = self._words[len(scalars) : end]
        self._functions = [(c.name, self._words_of(c), f) for c, f in columns if callable(f)]

    def _words_of(self, column: Column) -> int | slice:
        start = self.schema.dtype.fields[column.name][1] // 8  # type: ignore[index]
        return start if column.scalar else slice(start, start + column.size)

    def begin_run(self) -> int:
        """Return the number of the run that begins, counted from 1."""
        self._runs += 1
        return self._runs

    @property
    def runs(self) -> int:
        """Number of runs that have begun."""
        return self._runs

    @property
    def written(self) -> int:
        """Number of records written so far."""
        return self._ring.published

    def link(self) -> tuple[StreamLink, int]:
        """Return what `ChildProcess.send` needs to let a process read from the next record on."""
        ring = self._ring
        return StreamLink(self.schema, ring.capacity, ring.published), ring.descriptor

    def write(self, tick: Tick) -> None:
        """Write a tick's record. Takes some ten microseconds and never waits.

        Raises:
            SchemaError: a quantity of the tick is missing or has the wrong size.
        """
        try:
            self._numbers.pack_into(self._bytes, 0, *self._read_numbers(tick))
            np.concatenate(self._read_arrays(tick), out=self._array_words)
            self._varying.set_wrenches(tick.command.wrenches)
            if tick.contact_plan is not None:
                self._varying.set_contact_plan(tick.contact_plan, tick.index)
        except (AttributeError, TypeError, ValueError, struct.error) as error:
            raise SchemaError(self._misfit(tick)) from error
        self._varying.set_text(tick.command.explanation or tick.telemetry.status_text)
        words = self._words
        for name, place, function in self._functions:
            try:
                words[place] = function(tick)
            except Exception:
                logger.exception("the quantity '%s' fails and is NaN from now on", name)
                words[place] = np.nan
                self._functions = [f for f in self._functions if f[0] != name]
        self._publish()

    def repeat(self, mode: Mode, wall_time: float, values: Mapping[str, float]) -> None:
        """Write the last record once more, while there are no ticks.

        Args:
            mode: mode of the loop.
            wall_time: now, s since 1970.
            values: other numbers that have changed, by the names of columns.
        """
        if not self.written:
            return
        for name, value in {"mode": mode, "wall_time": wall_time, **values}.items():
            self._record[name] = value
        self._publish()

    def _publish(self) -> None:
        self._ring.rows[self._ring.begin()] = self._words
        self._ring.publish()

    def _misfit(self, tick: Tick) -> str:
        """Return which quantity of a tick is missing or has the wrong size."""
        for column, path in self._paths:
            try:
                value = attrgetter(path)(tick)
            except AttributeError as error:
                return f"the quantity '{column.name}' has no source '{path}': {error}"
            if column.scalar and not isinstance(value, numbers.Real):
                return f"{path} of the tick at {tick.time} s is {short_repr(value)}, not a number"
            if not column.scalar and np.shape(value) != (column.size,):
                shape = np.shape(value)
                return (
                    f"{path} of the tick at {tick.time} s has shape {shape}, not ({column.size},)"
                )
        return f"a wrench or the contact plan of the tick at {tick.time} s has a wrong shape"


class TickReader:
    """Reads in another process the stream that the parent process has attached last.

    Attributes:
        schema: schema of the records; another object for each stream.
    """

    def __init__(self) -> None:
        self.schema = Schema(())
        self._links: queue.SimpleQueue[StreamLink] = queue.SimpleQueue()
        self._ring: SharedRing | None = None
        self._every: RingReader | None = None
        self._newest: RingReader | None = None
        self._lost_before = 0  # on earlier streams

    def on_message(self, message: object) -> None:
        """Take a message of the parent, in any thread."""
        if isinstance(message, StreamLink):
            self._links.put(message)

    @property
    def lost(self) -> int:
        """Number of records that were overwritten before `take` returned them."""
        return self._lost_before + (self._every.lost if self._every is not None else 0)

    @property
    def waiting(self) -> int:
        """Number of records of the present stream that `take` could return."""
        return 0 if self._every is None else self._every.waiting

    def take(self, most: int) -> np.ndarray:
        """Return copies of the next records, oldest first, as a structured array, (n,).

        After the last record of a stream it goes over to the stream that was attached next.

        Args:
            most: number of records at most.
        """
        while True:
            attached = not self._links.empty()  # asked first: then the present stream has ended
            records = self._take(most)
            if len(records) or not attached:
                return records
            self._open_next()

    def latest(self) -> Any | None:
        """Return a copy of the newest record; None if there is none since the last call."""
        while not self._links.empty():
            self._open_next()
        row = None if self._newest is None else self._newest.latest()
        return None if row is None else row.view(self.schema.dtype)[0]

    def _take(self, most: int) -> np.ndarray:
        if self._every is None:
            return np.empty(0, self.schema.dtype)
        return self._every.take(most).view(self.schema.dtype)[:, 0]

    def _open_next(self) -> None:
        link = self._links.get()
        self._lost_before = self.lost
        self.close()
        self.schema = link.schema
        self._ring = SharedRing(link.schema.size, link.capacity, link.descriptor)
        self._every = RingReader(self._ring, link.first)
        self._newest = RingReader(self._ring, link.first)

    def close(self) -> None:
        """Close the descriptor."""
        if self._ring is not None:
            self._ring.close()

"""The stream of ticks: one record per tick in shared memory, for observers in other processes."""

from __future__ import annotations

import logging
import queue
import struct
import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.process.ring import RingReader, SharedRing
from wbc.runtime.mode import Mode
from wbc.runtime.quantities import QUANTITIES
from wbc.runtime.record import TickRecord
from wbc.runtime.schema import (
    CONTACTS,
    FOOTSTEPS,
    SUPPORT,
    SWING,
    TEXT,
    Quantity,
    Schema,
    SchemaError,
    expanded,
    schema_of,
)
from wbc.runtime.tick import Tick
from wbc.state import State
from wbc.telemetry import ContactPlan

if TYPE_CHECKING:
    from wbc.robot import Robot

logger = logging.getLogger(__name__)

CAPACITY = 4096  # ticks: eight seconds at 500 Hz
_NAMES, _NAME_SIZE = 64, 64  # names of contacts, bytes of each
_NO_WRENCH = np.full(6, np.nan)
_TRUTH = "truth."  # begins the paths of what a plant need not tell


@dataclass(frozen=True)
class StreamLink:
    """What another process needs to read a stream.

    Attributes:
        schema: of the records.
        capacity: of the ring.
        first: number of the first record to read.
        descriptor: of the ring's memory, in the process that has the link.
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
        schema: of the records.
        quantities: beside the library's own.

    Raises:
        SchemaError: two quantities have the same name.
    """

    def __init__(
        self, robot: Robot, quantities: Sequence[Quantity] = (), capacity: int = CAPACITY
    ) -> None:
        self.robot, self.quantities = robot, tuple(quantities)
        declared = (*QUANTITIES, *quantities)
        self.schema = schema_of(robot, declared)
        self._ring = SharedRing(self.schema.size, capacity, _NAMES * _NAME_SIZE)
        # The descriptor is closed with the stream, whose end no observer has to tell.
        self._finalizer = weakref.finalize(self, self._ring.close)
        self._source = _TickSource(robot, expanded(robot, declared))
        self._numbers = struct.Struct(f"={self.schema.numbers}d")
        row = 8 * self.schema.size
        self._offsets = [i * row for i in range(capacity)]
        self._arrays = slice(self.schema.numbers, self.schema.words("contact_plan_tick").start)
        self._vectors = [r[self._arrays] for r in self._ring.rows]
        # What changes seldom, contact plan and text, is kept and copied as a whole.
        self._seldom = slice(self.schema.words("contact_plan_tick").start, self.schema.size)
        self._tails = [r[self._seldom] for r in self._ring.rows]
        self._plan = _PlanBlock(np.full(self._tails[0].size, np.nan))
        self._padding = [np.full(7 * k, np.nan) for k in range(CONTACTS + 1)]
        self._names: dict[str, np.ndarray] = {}
        self._last = -1
        self._runs = 0

    def begin_run(self) -> int:
        """Return the number of the run that begins, counted from 1."""
        self._runs += 1
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
            SchemaError: an array of the tick has the wrong size.
        """
        numbers, arrays = self._source.read(tick)
        self._add_contacts(arrays, tick.command.wrenches)
        if tick.contact_plan is not None:
            self._plan.set_plan(tick.contact_plan, tick.index)
        self._plan.set_text(tick.command.explanation or tick.telemetry.status_text)
        ring = self._ring
        row = ring.begin()
        try:
            np.concatenate(arrays, out=self._vectors[row])
        except ValueError as error:
            raise SchemaError(self._source.misfit(tick)) from error
        self._tails[row][:] = self._plan.words
        self._numbers.pack_into(ring.bytes, self._offsets[row], *numbers)
        ring.publish()
        self._last = row

    def repeat(self, mode: Mode, wall_time: float, values: Mapping[str, float]) -> None:
        """Write the last record once more, while there are no ticks.

        Args:
            mode: of the loop.
            wall_time: now, s since 1970.
            values: other numbers that have changed, by the names of columns.
        """
        if self._last < 0:
            return
        ring, schema = self._ring, self.schema
        record = ring.rows[self._last].copy()
        for name, value in {"mode": mode, "wall_time": wall_time, **values}.items():
            record[schema.words(name)] = value
        self._append(record)

    def write_values(
        self,
        values: Mapping[str, Any],
        wrenches: Mapping[str, np.ndarray],
        plan: ContactPlan,
        text: str,
    ) -> None:
        """Write a record that is no tick of a loop; what is not given is NaN.

        Args:
            values: by the names of columns.
            wrenches: by the names of contacts.
            plan: where the robot stands and will step.
            text: one short line.

        Raises:
            SchemaError: a column does not exist, or its value has the wrong size.
        """
        schema = self.schema
        record = np.full(schema.size, np.nan)
        for name in ("mode", "status", "phase"):
            record[schema.words(name)] = 0.0
        for name, value in values.items():
            column = schema.column(name)
            shape = () if column.scalar else (column.size,)
            if np.shape(value) != shape:
                raise SchemaError(f"{name} has shape {np.shape(value)}, the record needs {shape}")
            record[schema.words(name)] = value
        arrays: list[np.ndarray] = []
        self._add_contacts(arrays, wrenches)
        try:
            record[schema.words("contacts")] = np.concatenate(arrays)
            self._plan.set_plan(plan, np.nan)
        except ValueError as error:
            raise SchemaError(f"a wrench or a point has the wrong size: {error}") from error
        self._plan.set_text(text)
        record[self._seldom] = self._plan.words
        self._append(record)

    def _append(self, record: np.ndarray) -> None:
        row = self._ring.begin()
        self._ring.rows[row] = record
        self._ring.publish()
        self._last = row

    def _add_contacts(self, arrays: list[np.ndarray], wrenches: Mapping[str, np.ndarray]) -> None:
        room = CONTACTS
        for name, wrench in wrenches.items():
            number = self._names.get(name)
            if number is None:
                number = self._names[name] = np.array([float(self._add_name(name))])
            if room:
                arrays += (number, wrench)
                room -= 1
        arrays.append(self._padding[room])

    def _add_name(self, name: str) -> int:
        number = len(self._names)
        if number >= _NAMES:
            return -1
        text = name.encode("utf-8", "replace")[: _NAME_SIZE - 1]
        header = self._ring.header
        header[number * _NAME_SIZE : number * _NAME_SIZE + len(text) + 1] = text + b"\0"
        return number


class TickReader:
    """Reads a stream in another process: every tick by `take`, and the newest by `latest`.

    Args:
        link: from `TickStream.link`.

    Attributes:
        schema: of the records.
    """

    def __init__(self, link: StreamLink) -> None:
        self.schema = link.schema
        self._ring = SharedRing(
            link.schema.size, link.capacity, _NAMES * _NAME_SIZE, link.descriptor
        )
        self._reader = RingReader(self._ring, link.first)
        self._newest = RingReader(self._ring, link.first)
        self._names: list[str] = []

    @property
    def lost(self) -> int:
        """Ticks that were overwritten before this reader took them."""
        return self._reader.lost

    def take(self, most: int) -> np.ndarray:
        """Return copies of the next records, oldest first, as a structured array, (n,).

        Args:
            most: number of records at most.
        """
        return self._reader.take(most).view(self.schema.dtype)[:, 0]

    def latest(self) -> TickRecord | None:
        """Return a copy of the newest record; None if there is none since the last call."""
        row = self._newest.latest()
        if row is None:
            return None
        return TickRecord(self.schema, row.view(self.schema.dtype)[0], self.contact_names)

    @property
    def contact_names(self) -> list[str]:
        """Names of contacts, by the numbers in the records."""
        header = bytes(self._ring.header[len(self._names) * _NAME_SIZE :])
        while header[:1] not in (b"", b"\0"):
            name, header = header[:_NAME_SIZE], header[_NAME_SIZE:]
            self._names.append(name.partition(b"\0")[0].decode("utf-8", "ignore"))
        return self._names

    def close(self) -> None:
        """Close the descriptor."""
        self._ring.close()


class StreamFollower:
    """Reads whichever stream the parent process has attached last.

    Attributes:
        reader: of the latest stream; None before the first.
    """

    def __init__(self) -> None:
        self.reader: TickReader | None = None
        self._links: queue.SimpleQueue[StreamLink] = queue.SimpleQueue()

    def on_message(self, message: object) -> None:
        """Take a message of the parent, in any thread."""
        if isinstance(message, StreamLink):
            self._links.put(message)

    @property
    def pending(self) -> bool:
        """Whether `update` would go over to another stream."""
        return not self._links.empty()

    def update(self) -> bool:
        """Go over to the next stream, if there is one; returns whether `reader` is another now."""
        if self._links.empty():
            return False
        if self.reader is not None:
            self.reader.close()
        self.reader = TickReader(self._links.get())
        return True


class _PlanBlock:
    """The words of a record that change seldom: contact plan and text.

    Args:
        words: their memory.
    """

    def __init__(self, words: np.ndarray) -> None:
        self.words = words
        ends = np.cumsum([1, 3 * SUPPORT, 5 * FOOTSTEPS, 3 * SWING])
        self._tick, support, footsteps, swing, text = np.split(words, ends)
        self._support, self._swing = support.reshape(-1, 3), swing.reshape(-1, 3)
        self._footsteps = footsteps.reshape(-1, 5)
        text[:] = 0.0
        self._bytes = text.view(np.uint8)
        self._text = ""

    def set_plan(self, plan: ContactPlan, tick: float) -> None:
        """Copy the contact plan of a tick; what exceeds the bounds is left out."""
        self._tick[0] = tick
        _copy_rows(self._support, plan.support)
        path = plan.swing_path
        if len(path) > SWING:
            path = path[np.linspace(0, len(path) - 1, SWING).round().astype(int)]
        _copy_rows(self._swing, path)
        self._footsteps[:] = np.nan
        for row, step in zip(self._footsteps, plan.footsteps, strict=False):
            row[0] = step.side == "right"
            row[1:4] = step.position
            row[4] = step.yaw

    def set_text(self, text: str) -> None:
        """Write a text, cut to the bytes that there are."""
        if text is self._text:
            return
        self._text = text
        data = text.encode("utf-8", "replace")[:TEXT]
        self._bytes[: len(data)] = np.frombuffer(data, np.uint8)
        self._bytes[len(data) :] = 0


def _copy_rows(rows: np.ndarray, points: np.ndarray) -> None:
    count = min(len(points), len(rows))
    if count:
        rows[:count] = points[:count]
    rows[count:] = np.nan


class _TickSource:
    """Reads the declared quantities from ticks, with one call for all attributes of one kind.

    Args:
        robot: the robot.
        quantities: all of them, in the order of the schema.
    """

    def __init__(self, robot: Robot, quantities: Sequence[tuple[Quantity, str]]) -> None:
        numbers = [q for q, _ in quantities if q.size == 1]
        arrays = [(q, sole) for q, sole in quantities if q.size != 1]
        self._numbers = _getter([q.source for q in numbers if isinstance(q.source, str)])
        self._number_functions = [_Guarded(q, 1) for q in numbers if callable(q.source)]
        paths = [q.source for q, sole in arrays if isinstance(q.source, str) and not sole]
        true = [path[len(_TRUTH) :] for path in paths if path.startswith(_TRUTH)]
        self._arrays = _getter([path for path in paths if not path.startswith(_TRUTH)])
        self._truth = _getter(true)
        self._unknown = State(np.full(robot.nq, np.nan), np.full(robot.nv, np.nan))
        self._by_sole = [
            (attrgetter(q.source), sole) for q, sole in arrays if isinstance(q.source, str) and sole
        ]
        sizes = {"na": robot.na, "nq": robot.nq, "nv": robot.nv}
        self._array_functions = [
            _Guarded(q, sizes[q.size] if isinstance(q.size, str) else q.size)
            for q, _ in arrays
            if callable(q.source)
        ]
        self._sizes = [
            (q.source, sizes[q.size] if isinstance(q.size, str) else q.size)
            for q, sole in arrays
            if isinstance(q.source, str) and not sole
        ]

    def read(self, tick: Tick) -> tuple[list[Any], list[np.ndarray]]:
        """Return the numbers and the arrays in the order of the schema."""
        numbers = [*self._numbers(tick), *[read(tick) for read in self._number_functions]]
        arrays = [*self._arrays(tick), *self._truth(tick.truth or self._unknown)]
        for wrenches, sole in self._by_sole:
            arrays.append(wrenches(tick).get(sole, _NO_WRENCH))
        for read in self._array_functions:
            arrays.append(read(tick))
        return numbers, arrays

    def misfit(self, tick: Tick) -> str:
        """Return which array of a tick has the wrong size."""
        for path, size in self._sizes:
            if path.startswith(_TRUTH) and tick.truth is None:
                continue
            shape = np.shape(attrgetter(path)(tick))
            if shape != (size,):
                return f"{path} of the tick at {tick.time} s has shape {shape}, not ({size},)"
        return f"a wrench of the tick at {tick.time} s does not have six numbers"


class _Guarded:
    """Reads a quantity by its function; one that fails is NaN from then on, and a warning says so.

    Args:
        quantity: whose source is a function.
        size: of its value.
    """

    def __init__(self, quantity: Quantity, size: int) -> None:
        assert callable(quantity.source)
        self._name, self._function = quantity.name, quantity.source
        self._size, self._scalar = size, quantity.size == 1
        self._failed = False

    def __call__(self, tick: Tick) -> Any:
        if not self._failed:
            try:
                value = self._function(tick)
                if self._scalar:
                    return float(value)
                return np.asarray(value, dtype=float).reshape(self._size)
            except Exception:
                self._failed = True
                logger.exception("the quantity '%s' fails and is NaN from now on", self._name)
        return np.nan if self._scalar else np.full(self._size, np.nan)


def _getter(paths: Sequence[str]) -> Callable[[Any], tuple[Any, ...]]:
    """Return a function of an object that returns the attributes at these paths."""
    if len(paths) > 1:
        return attrgetter(*paths)
    if not paths:
        return lambda _: ()
    only = attrgetter(paths[0])
    return lambda thing: (only(thing),)

"""The last minutes of a session, kept by the process of the page."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.live.sample_block import SAMPLES, SampleBlock, SampleLayout
from wbc.runtime.mode import Mode
from wbc.runtime.schema import Schema
from wbc.runtime.snapshot import Snapshot
from wbc.topics import BatchMaker

if TYPE_CHECKING:
    from wbc.robot import Robot

DURATION = 720.0  # s that are kept at least
PERIOD = 0.02  # s between two samples
#: Blocks whose extremes are kept for each sample; those of older ones are joined.
_RECENT = 16


@dataclass(frozen=True, eq=False)
class Series:
    """A quantity over time: its least and largest values between a sample and the one before.

    Attributes:
        time: Session times of the samples, s, shape (n,).
        low: Least values, shape (n,); NaN where unknown.
        high: Largest values, shape (n,).
    """

    time: np.ndarray
    low: np.ndarray
    high: np.ndarray


@dataclass(eq=False)
class _Waiting:
    """Ticks that are not yet a sample, as rows of numbers, and their session times, s."""

    words: list[np.ndarray] = field(default_factory=list)
    time: list[np.ndarray] = field(default_factory=list)
    count: int = 0


class History:
    """Samples of the ticks of the last minutes, with the extremes of what lies between them.

    Older samples are compressed: those of a robot with 32 joints take less than 3 kB each, with
    the inputs of the controller's QP. Of the extremes, those of the last half minute are kept for
    each sample, and older ones ten times a second.

    Its time is that of the session: plant time, continued over resets, as in a log. It is a
    `wbc.view.Timeline`.

    Args:
        robot: Robot of the ticks.
        dt: Control period, s.
        duration: Time that is kept at least, s.

    Attributes:
        count: Number of samples so far, also of those that are no longer kept.
        starts: Session time, s, of the time 0 of each run, by its number.
    """

    def __init__(self, robot: Robot, dt: float, duration: float = DURATION) -> None:
        self._stamps = BatchMaker(robot)
        self._every = max(1, round(PERIOD / dt))  # ticks per sample
        self._blocks: deque[SampleBlock] = deque(
            maxlen=1 + int(np.ceil(duration / (self._every * dt * SAMPLES)))
        )
        self._schema = Schema(())
        self._layout = SampleLayout(self._schema)
        self._shown: tuple[SampleBlock, np.ndarray] | None = None  # and its records
        self._waiting = _Waiting()
        self.count = 0
        self.starts: dict[int, float] = {}

    def __len__(self) -> int:
        """Return the number of samples that are kept."""
        return sum(block.used for block in self._blocks)

    def add(self, ticks: np.ndarray, schema: Schema) -> None:
        """Add ticks; those that only repeat the last one while the loop waits are left out.

        Args:
            ticks: Records, shape (n,).
            schema: Their schema; samples of another one are forgotten.
        """
        if schema is not self._schema:
            self._schema, self._layout, self._waiting = schema, SampleLayout(schema), _Waiting()
            self._blocks.clear()
            self._shown = None
        running = ticks[ticks["mode"] == Mode.RUNNING]
        if len(running):
            time = 1e-9 * self._stamps.batch(running).stamps
            for run in np.unique(running["run"]):
                first = int(np.argmax(running["run"] == run))
                start = float(time[first] - running["time"][first])
                self.starts.setdefault(int(run), start)
            # Rows of numbers: numpy joins arrays of records very slowly.
            self._waiting.words.append(running.view("f8").reshape(len(running), -1))
            self._waiting.time.append(time)
            self._waiting.count += len(running)
        waiting = self._waiting
        # What comes last before a fall or a pause is not kept waiting.
        ended = len(running) < len(ticks) and waiting.count > 0
        if waiting.count >= self._every or ended:
            self._waiting = _Waiting()
            self._sample(np.concatenate(waiting.words), np.concatenate(waiting.time), ended)

    def _sample(self, words: np.ndarray, time: np.ndarray, ended: bool) -> None:
        count = len(words)
        whole = count - count % self._every
        ends = list(range(self._every, whole + 1, self._every))
        if ended and whole < count:
            ends.append(count)
        elif whole < count:
            self._waiting = _Waiting([words[whole:]], [time[whole:]], count - whole)
        start = 0
        for end in ends:
            self._block_with_room().append(words[start:end], float(time[end - 1]))
            self.count += 1
            start = end

    def _block_with_room(self) -> SampleBlock:
        blocks = self._blocks
        if not blocks or blocks[-1].full:
            if blocks:
                blocks[-1].compress_records()
            if len(blocks) >= _RECENT:
                blocks[-_RECENT].compress_extremes()
            blocks.append(SampleBlock(self._layout))
        return blocks[-1]

    @property
    def start(self) -> float:
        """Session time of the first sample, s."""
        return float(self._blocks[0].time[0]) if self._blocks else 0.0

    @property
    def end(self) -> float:
        """Session time of the last sample, s."""
        return float(self._blocks[-1].time[self._blocks[-1].used - 1]) if self._blocks else 0.0

    def at(self, time: float) -> Snapshot:
        """Return the snapshot of the last sample at or before a time (s), or of the first.

        Raises:
            IndexError: There is no sample yet.
        """
        return Snapshot.of_record(self.record_at(time))

    def record_at(self, time: float) -> Any:
        """Return the record of the last sample at or before a time (s), or of the first.

        Raises:
            IndexError: There is no sample yet.
        """
        block = self._blocks[0]
        for later in self._blocks:
            if later.time[0] > time + 1e-9:
                break
            block = later
        index = int(np.searchsorted(block.time[: block.used], time + 1e-9, "right")) - 1
        if block is self._blocks[-1]:
            return block.records()[max(index, 0)]
        if self._shown is None or self._shown[0] is not block:
            self._shown = block, block.records()
        return self._shown[1][max(index, 0)]

    def stretch(self, start: float, end: float) -> tuple[np.ndarray, np.ndarray]:
        """Return copies of the records between two times (s), and their session times, s."""
        slices = [
            slice(*np.searchsorted(block.time[: block.used], (start - 1e-9, end + 1e-9)).tolist())
            for block in self._blocks
        ]
        count = sum(one.stop - one.start for one in slices)
        words, times = np.empty((count, self._schema.size)), np.empty(count)
        at = 0
        for block, within in zip(self._blocks, slices, strict=True):
            if within.start < within.stop:
                rows = slice(at, at + within.stop - within.start)
                words[rows] = block.records().view("f8").reshape(block.used, -1)[within]
                times[rows] = block.time[within]
                at = rows.stop
        return words.view(self._schema.dtype)[:, 0], times

    def series(self, places: Sequence[int], since: int, points: int) -> list[Series]:
        """Return quantities over time, of which those long ago are joined to fewer points.

        Args:
            places: Place of each quantity among the numbers of a tick.
            since: Number of the first sample, counted as in `count`.
            points: Largest number of points of the older half and of the newer half each.
        """
        skipped = max(since - (self.count - len(self)), 0)
        times: list[np.ndarray] = []
        lows: list[np.ndarray] = []
        highs: list[np.ndarray] = []
        for block in self._blocks:
            first = min(skipped, block.used)
            skipped -= first
            if first < block.used:
                for joined, part in zip(
                    (times, lows, highs), block.extremes(places, first), strict=True
                ):
                    joined.append(part)
        if not times:
            return [Series(np.empty(0), np.empty(0), np.empty(0)) for _ in places]
        time, low, high = np.concatenate(times), np.concatenate(lows), np.concatenate(highs)
        old = max(len(time) - points, 0)
        if old:
            every = -(-old // points)
            starts = np.arange(0, old, every)
            ends = np.append(starts[1:], old) - 1
            time = np.concatenate((time[ends], time[old:]))
            low = np.concatenate((np.fmin.reduceat(low[:old], starts), low[old:]))
            high = np.concatenate((np.fmax.reduceat(high[:old], starts), high[old:]))
        return [Series(time, low[:, k], high[:, k]) for k in range(len(places))]

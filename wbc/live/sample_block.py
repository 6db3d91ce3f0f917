"""Consecutive samples of a session, of which the older ones are compressed."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wbc.runtime.schema import Schema

SAMPLES = 100  # of a block: more would hold up the page while they are compressed
_JOINED = 5  # samples whose extremes become one
_LEVEL = 1  # of zlib: higher ones take several times as long and save a few percent


@dataclass(frozen=True, eq=False)
class SampleLayout:
    """Where the words of a record go when it is compressed.

    Quantities that a log holds in single precision are held so here, too: a log of the samples
    has the same numbers as one that was recorded.

    Attributes:
        schema: Schema of the records.
    """

    schema: Schema

    @cached_property
    def numbers(self) -> int:
        """Number of words that are numbers; packed quantities and varying fields follow."""
        return sum(column.size for column in self.schema.numbers)

    @cached_property
    def single(self) -> np.ndarray:
        """Whether each number is held in single precision, shape (numbers,)."""
        return np.repeat(
            [column.single for column in self.schema.numbers],
            [column.size for column in self.schema.numbers],
        ).astype(bool)


class SampleBlock:
    """Consecutive samples: records, session times, and the extremes since the sample before.

    Args:
        layout: layout of the records.

    Attributes:
        time: Session times, s; the first `used` of them are valid.
        used: Number of samples.
    """

    def __init__(self, layout: SampleLayout) -> None:
        self._layout = layout
        self.time = np.empty(SAMPLES)
        self.used = 0
        self._records: np.ndarray | tuple[bytes, ...] = np.empty(SAMPLES, layout.schema.dtype)
        self._extremes: np.ndarray | bytes = np.empty((2, SAMPLES, layout.numbers), "f4")

    @property
    def full(self) -> bool:
        """Whether there is no room for another sample."""
        return self.used == SAMPLES

    def append(self, words: np.ndarray, time: float) -> None:
        """Add a sample.

        Args:
            words: Records as rows of numbers: all ticks since the sample before, and the sample.
            time: Session time of the sample, s.
        """
        records, extremes, numbers = self._records, self._extremes, words[:, : self._layout.numbers]
        assert isinstance(records, np.ndarray)
        assert isinstance(extremes, np.ndarray)
        at, self.used = self.used, self.used + 1
        records[at], self.time[at] = words[-1].view(records.dtype)[0], time
        # fmin and fmax pass over values that are not known.
        np.fmin.reduce(numbers, axis=0, out=extremes[0, at])
        np.fmax.reduce(numbers, axis=0, out=extremes[1, at])

    def compress_records(self) -> None:
        """Compress the records of a full block."""
        records, layout = self._records, self._layout
        if not isinstance(records, np.ndarray):
            return
        words = records.view("f8").reshape(SAMPLES, -1)
        numbers, single = words[:, : layout.numbers], layout.single
        with np.errstate(over="ignore"):
            singles = numbers[:, single].astype("f4")
        self._records = (
            _compressed(numbers[:, ~single]),
            _compressed(singles),
            _compressed(words[:, layout.numbers :], "u8"),
        )

    def compress_extremes(self) -> None:
        """Join the extremes of a full block to fewer, and compress them."""
        if isinstance(self._extremes, np.ndarray):
            low, high = self._extremes.reshape(2, SAMPLES // _JOINED, _JOINED, -1)
            joined = np.fmin.reduce(low, axis=1), np.fmax.reduce(high, axis=1)
            self._extremes = _compressed(np.concatenate(joined))

    def records(self) -> np.ndarray:
        """Return the records, shape (used,)."""
        if isinstance(self._records, np.ndarray):
            return self._records[: self.used]
        layout = self._layout
        doubles, singles, others = self._records
        words = np.empty((SAMPLES, layout.schema.size))
        words[:, : layout.numbers][:, ~layout.single] = _rows(doubles, SAMPLES).view("f8")
        words[:, : layout.numbers][:, layout.single] = _rows(singles, SAMPLES).view("f4")
        words.view("u8")[:, layout.numbers :] = _rows(others, SAMPLES, "u8")
        return words.view(layout.schema.dtype)[:, 0]

    def extremes(
        self, places: Sequence[int], first: int
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return times, s, shape (n,), and the least and largest values, shape (n, places).

        Args:
            places: Place of each quantity among the numbers of a record.
            first: Number of the first sample in the block.
        """
        if isinstance(self._extremes, np.ndarray):
            low, high = self._extremes[:, first : self.used][:, :, places]
            return self.time[first : self.used], low, high
        first //= _JOINED
        rows = _rows(self._extremes, 2 * SAMPLES // _JOINED).view("f4")[:, places]
        low, high = rows.reshape(2, SAMPLES // _JOINED, -1)[:, first:]
        return self.time[_JOINED - 1 :: _JOINED][first:], low, high


def _compressed(rows: np.ndarray, dtype: str = "u1") -> bytes:
    """Return rows compressed column by column, where neighbours resemble each other.

    Args:
        rows: The rows.
        dtype: Type of a column: single bytes ("u1") of measured numbers, or words ("u8").
    """
    columns = np.ascontiguousarray(rows).view(dtype).T
    return zlib.compress(columns.tobytes(), _LEVEL)


def _rows(data: bytes, count: int, dtype: str = "u1") -> np.ndarray:
    """Return the rows that `_compressed` was given, as columns of that type."""
    columns = np.frombuffer(zlib.decompress(data), dtype).reshape(-1, count)
    return np.ascontiguousarray(columns.T)

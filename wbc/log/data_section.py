"""The data section of an MCAP file: what of it can be read, and what is missing.

The module needs the packages of the extra `log`: import it where it is used.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import IO, NamedTuple, TypeAlias

from mcap import records
from mcap.opcode import Opcode

from wbc.log.record_reader import (
    Block,
    Damage,
    SummarySection,
    block_at,
    blocks,
    check_magic,
    chunk_content,
)
from wbc.log.time_span import WHOLE_RUN, TimeSpan


class Gap(NamedTuple):
    """A part of a run that a damaged log lacks.

    Attributes:
        start: Time of the last message before it, s; 0 if there is none.
        end: Time of the first message after it, s; NaN if it is unknown.
    """

    start: float
    end: float

    def __str__(self) -> str:
        """Return e.g. "1.200 s to 1.600 s"."""
        return f"{self.start:.3f} s to " + (
            f"{self.end:.3f} s" if math.isfinite(self.end) else "the end"
        )


class ChunkPlace(NamedTuple):
    """Where a chunk is, and when.

    Attributes:
        offset: Offset of its record, bytes.
        start: Time of its first message, ns.
        end: Time of its last message, ns.
    """

    offset: int
    start: int
    end: int

    @staticmethod
    def of(block: Block, chunk: records.Chunk) -> ChunkPlace:
        """Return the place of a chunk that a block holds."""
        return ChunkPlace(block.start, chunk.message_start_time, chunk.message_end_time)


def read_chunk(file: IO[bytes], place: ChunkPlace) -> bytes:
    """Return the records of a chunk, not compressed.

    Raises:
        ValueError: There is no whole chunk at that place any more.
    """
    block = block_at(file, place.offset)
    if block is None or block.opcode != Opcode.CHUNK:
        raise ValueError("the file has changed")
    return chunk_content(block.parse())


class ChunkBlock(NamedTuple):
    """A chunk that is whole.

    Attributes:
        record: The chunk.
        content: Its records, not compressed.
    """

    record: records.Chunk
    content: bytes


#: What a block holds; None for an index of messages, which is not parsed, and for a chunk beyond
#: the span that is read.
Content: TypeAlias = ChunkBlock | records.Attachment | records.Metadata | None


class DataSection:
    """Reads what is whole of the data section of an MCAP file.

    Args:
        file: File open for reading.
        span: Part of the run to read. Chunks beyond it are not read if the summary section says
            where they are, and else not looked into.

    Attributes:
        summary: The file's summary section.
        finished: Whether the file has its end.
        gaps: What is missing because it is damaged, known after the iteration; the end of a log
            that was interrupted is not.

    Raises:
        LogError: The file is not an MCAP file.
    """

    def __init__(self, file: IO[bytes], span: TimeSpan = WHOLE_RUN) -> None:
        check_magic(file)
        self._file, self._span = file, span
        self.summary = SummarySection(file)
        self.finished = self.summary.found
        self.gaps: list[Gap] = []
        self._last = 0.0  # s, of the last message that was read

    def __iter__(self) -> Iterator[tuple[Block, Content]]:
        """Yield chunks, attachments and metadata, each with its block, and indices of messages."""
        damage: int | None = None  # where it begins, bytes
        for block in blocks(self._file, self.summary, self._skipped()):
            if isinstance(block, Damage):
                damage = block.start if damage is None else damage
                continue
            if block.opcode == Opcode.MESSAGE_INDEX:
                yield block, None
            if block.opcode not in (Opcode.CHUNK, Opcode.ATTACHMENT, Opcode.METADATA):
                continue
            try:
                record = block.parse()
                if isinstance(record, records.Chunk):
                    start, end = record.message_start_time, record.message_end_time
                    if not self._span.overlaps(start, end):
                        self._last, damage = 1e-9 * end, None
                        continue
                    record = ChunkBlock(record, chunk_content(record))
            except ValueError:
                if block.opcode == Opcode.CHUNK and damage is None:
                    damage = block.start
                continue
            if isinstance(record, ChunkBlock):
                if damage is not None:
                    self._add_gap(damage, 1e-9 * record.record.message_start_time)
                damage = None
                self._last = 1e-9 * record.record.message_end_time
            yield block, record
        if damage is not None and self.finished:
            beyond = set(self._skipped())
            chunks = self.summary.chunks.values()
            following = (c.first for c in chunks if c.start > damage and c.start in beyond)
            self._add_gap(damage, 1e-9 * min(following, default=self.summary.end_time))

    def _add_gap(self, damage: int, end: float) -> None:
        """Add the gap of damage that begins at an offset, up to a time, s."""
        before = (1e-9 * c.last for c in self.summary.chunks.values() if c.end <= damage)
        self.gaps.append(Gap(max(before, default=self._last), end))

    def _skipped(self) -> dict[int, int]:
        """Return start and end of the chunks that the span does not need, with their indices."""
        return {
            chunk.start: chunk.end
            for chunk in self.summary.chunks.values()
            if chunk.end > chunk.start and not self._span.overlaps(chunk.first, chunk.last)
        }

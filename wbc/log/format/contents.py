"""The contents of an MCAP file, and the summary at its end that indexes them."""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from dataclasses import dataclass, field

from wbc.log.format.records import (
    ATTACHMENT_INDEX,
    CHANNEL,
    CHUNK_INDEX,
    DATA_END,
    FOOTER,
    HEAD,
    MAGIC,
    METADATA_INDEX,
    SCHEMA,
    STATISTICS,
    SUMMARY_OFFSET,
    numbers,
    record,
    text,
)


@dataclass
class ChunkInfo:
    """A chunk and the indices behind it.

    Attributes:
        offset: where it begins in the file.
        length: bytes of its record.
        start: time of its first message, ns.
        end: time of its last message, ns.
        compression: of its records.
        packed: bytes of its records, compressed.
        size: bytes of its records.
        counts: channel -> number of its messages.
        indices: channel -> where its index is in the file.
        indices_length: bytes of all indices.
    """

    offset: int
    length: int
    start: int
    end: int
    compression: str
    packed: int
    size: int
    counts: Counter[int] = field(default_factory=Counter)
    indices: dict[int, int] = field(default_factory=dict)
    indices_length: int = 0

    @property
    def after(self) -> int:
        """Where it ends with its indices."""
        return self.offset + self.length + self.indices_length

    def drop_indices(self) -> None:
        """Leave the indices out: a chunk is read with all or with none."""
        self.indices.clear()
        self.indices_length = 0


@dataclass(frozen=True)
class RecordLocation:
    """A metadata or attachment record.

    Attributes:
        offset: where it begins in the file.
        length: bytes of the record.
        about: what its index tells besides.
    """

    offset: int
    length: int
    about: bytes


@dataclass
class Contents:
    """The contents of a file.

    Attributes:
        schemas: by number, contents of their records.
        channels: likewise.
        chunks: in their order.
        metadata: where they are.
        attachments: where they are.
    """

    schemas: dict[int, bytes] = field(default_factory=dict)
    channels: dict[int, bytes] = field(default_factory=dict)
    chunks: list[ChunkInfo] = field(default_factory=list)
    metadata: list[RecordLocation] = field(default_factory=list)
    attachments: list[RecordLocation] = field(default_factory=list)

    @property
    def end(self) -> int:
        """Time of the last message, ns."""
        return max((chunk.end for chunk in self.chunks), default=0)

    def drop_last_chunk(self) -> int:
        """Leave out the last chunk and what follows it; where it began."""
        offset = self.chunks.pop().offset
        self.metadata = [place for place in self.metadata if place.offset < offset]
        self.attachments = [place for place in self.attachments if place.offset < offset]
        return offset

    def ending(self, start: int) -> bytes:
        """Everything after the data, from `start` to the end of the file."""
        data_end = record(DATA_END, struct.pack("<I", 0))
        summary, offsets = b"", b""
        for opcode, group in self._groups():
            begin = start + len(data_end) + len(summary)
            records = b"".join(record(opcode, content) for content in group)
            if records:
                offset = struct.pack("<BQQ", opcode, begin, len(records))
                offsets += record(SUMMARY_OFFSET, offset)
            summary += records
        summary_start = start + len(data_end)
        places = struct.pack("<QQ", summary_start, summary_start + len(summary))
        checked = summary + offsets + HEAD.pack(FOOTER, len(places) + 4) + places
        return data_end + checked + struct.pack("<I", zlib.crc32(checked)) + MAGIC

    def _groups(self) -> list[tuple[int, list[bytes]]]:
        return [
            (SCHEMA, list(self.schemas.values())),
            (CHANNEL, list(self.channels.values())),
            (STATISTICS, [self._statistics()]),
            (CHUNK_INDEX, [_chunk_index(chunk) for chunk in self.chunks]),
            (ATTACHMENT_INDEX, [_place(place) for place in self.attachments]),
            (METADATA_INDEX, [_place(place) for place in self.metadata]),
        ]

    def _statistics(self) -> bytes:
        counts: Counter[int] = Counter()
        for chunk in self.chunks:
            counts += chunk.counts
        head = struct.pack(
            "<QHIIIIQQ",
            sum(counts.values()),
            len(self.schemas),
            len(self.channels),
            len(self.attachments),
            len(self.metadata),
            len(self.chunks),
            min((chunk.start for chunk in self.chunks), default=0),
            self.end,
        )
        return head + numbers(counts)


def _chunk_index(chunk: ChunkInfo) -> bytes:
    head = struct.pack("<QQQQ", chunk.start, chunk.end, chunk.offset, chunk.length)
    indices = numbers(chunk.indices) + struct.pack("<Q", chunk.indices_length)
    return head + indices + text(chunk.compression) + struct.pack("<QQ", chunk.packed, chunk.size)


def _place(place: RecordLocation) -> bytes:
    return struct.pack("<QQ", place.offset, place.length) + place.about

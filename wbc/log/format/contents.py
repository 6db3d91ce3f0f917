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
    """A chunk and the message indices that follow it.

    Attributes:
        offset: Offset of the chunk in the file, bytes.
        length: Size of the chunk record, bytes.
        start: Time of the first message, ns.
        end: Time of the last message, ns.
        compression: Compression of the records.
        packed: Compressed size of the records, bytes.
        size: Uncompressed size of the records, bytes.
        counts: Maps each channel to its number of messages.
        indices: Maps each channel to the offset of its message index in the file, bytes.
        indices_length: Size of all message indices, bytes.
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
        """Offset of the end of the chunk and its message indices, bytes."""
        return self.offset + self.length + self.indices_length

    def drop_indices(self) -> None:
        """Drop the message indices: a chunk has either all of them or none."""
        self.indices.clear()
        self.indices_length = 0


@dataclass(frozen=True)
class RecordLocation:
    """A metadata or attachment record.

    Attributes:
        offset: Offset of the record in the file, bytes.
        length: Size of the record, bytes.
        about: Further content of its index record.
    """

    offset: int
    length: int
    about: bytes


@dataclass
class Contents:
    """The contents of an MCAP file.

    Attributes:
        schemas: Maps each schema id to the content of its record.
        channels: Maps each channel id to the content of its record.
        chunks: The chunks in file order.
        metadata: Locations of the metadata records.
        attachments: Locations of the attachment records.
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
        """Drop the last chunk and everything after it; return the chunk's offset, bytes."""
        offset = self.chunks.pop().offset
        self.metadata = [place for place in self.metadata if place.offset < offset]
        self.attachments = [place for place in self.attachments if place.offset < offset]
        return offset

    def ending(self, start: int) -> bytes:
        """Return the bytes that follow the data section, which ends at offset `start`."""
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

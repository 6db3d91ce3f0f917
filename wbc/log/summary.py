"""The summary section at the end of an MCAP file, by which readers find its content.

Source: MCAP format specification, version 0.
"""

from __future__ import annotations

import itertools
import struct
import zlib
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from io import BytesIO

from mcap import records
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

_FOOTER = struct.Struct("<BQQQ")  # opcode, length of the content, offsets of its two sections
_HEAD_LENGTH = 9  # bytes: opcode and length of the content
_FOOTER_LENGTH = 20  # bytes: both offsets and the checksum


class Summary:
    """What a file has, and where.

    Attributes:
        schemas: Schemas by number.
        channels: Channels by number.
        last_chunk: Index of the last chunk; None while there is none.
        attachments: Indices of the attachments.
        metadata: Indices of the metadata.
    """

    def __init__(self) -> None:
        self.schemas: dict[int, records.Schema] = {}
        self.channels: dict[int, records.Channel] = {}
        self.last_chunk: records.ChunkIndex | None = None
        #: Indices of the chunks before it, encoded: they take a tenth of the memory then.
        self._encoded: list[bytes] = []
        self.attachments: list[records.AttachmentIndex] = []
        self.metadata: list[records.MetadataIndex] = []
        self._counts: list[array[int]] = []  # channel, number of its messages, next channel, …

    def add_chunk(
        self, chunk: records.Chunk, start: int, length: int, counts: Mapping[int, int]
    ) -> records.ChunkIndex:
        """Add a chunk and return its index, which does not have the message indices yet.

        Args:
            chunk: The chunk.
            start: Offset of its record, bytes.
            length: Length of its record, bytes.
            counts: Number of messages of each channel.
        """
        if self.last_chunk is not None:
            self._encoded.append(_encoded(self.last_chunk))
        self.last_chunk = records.ChunkIndex(
            chunk_start_offset=start,
            chunk_length=length,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            uncompressed_size=chunk.uncompressed_size,
            message_start_time=chunk.message_start_time,
            message_end_time=chunk.message_end_time,
            message_index_offsets={},
            message_index_length=0,
        )
        self._counts.append(array("I", itertools.chain.from_iterable(counts.items())))
        return self.last_chunk

    def add_attachment(self, attachment: records.Attachment, start: int, length: int) -> None:
        """Add an attachment, whose record begins at offset `start` and has `length` bytes."""
        self.attachments.append(
            records.AttachmentIndex(
                offset=start,
                length=length,
                log_time=attachment.log_time,
                create_time=attachment.create_time,
                data_size=len(attachment.data),
                name=attachment.name,
                media_type=attachment.media_type,
            )
        )

    def add_metadata(self, metadata: records.Metadata, start: int, length: int) -> None:
        """Add metadata, whose record begins at offset `start` and has `length` bytes."""
        self.metadata.append(records.MetadataIndex(offset=start, length=length, name=metadata.name))

    def add(self, record: records.Attachment | records.Metadata, start: int, length: int) -> None:
        """Add an attachment or metadata; see `add_attachment`."""
        if isinstance(record, records.Attachment):
            self.add_attachment(record, start, length)
        else:
            self.add_metadata(record, start, length)

    def add_message_index(self, channel: int, start: int, length: int) -> None:
        """Add the index of the messages that a channel has in the last chunk."""
        assert self.last_chunk is not None
        self.last_chunk.message_index_offsets[channel] = start
        self.last_chunk.message_index_length += length

    def drop_partial_index(self) -> bool:
        """Drop the indices of the last chunk's messages unless all channels have one.

        Returns:
            Whether some were missing.
        """
        last = self.last_chunk
        if last is None or set(last.message_index_offsets) == set(self._counts[-1][::2]):
            return False
        last.message_index_offsets.clear()
        last.message_index_length = 0
        return True

    @property
    def end_time(self) -> float:
        """Time of the last message, s; 0 if there is none."""
        return 1e-9 * max((chunk.message_end_time for chunk in self._chunks()), default=0)

    def drop_last_chunk(self) -> int:
        """Drop the last chunk and what follows it; return the chunk's offset, bytes."""
        assert self.last_chunk is not None
        self._counts.pop()
        size: int = self.last_chunk.chunk_start_offset
        self.last_chunk = _decoded(self._encoded.pop()) if self._encoded else None
        self.attachments = [index for index in self.attachments if index.offset < size]
        self.metadata = [index for index in self.metadata if index.offset < size]
        return size

    def encode(self, size: int) -> bytes:
        """Return the bytes that complete a file whose data section ends at `size` bytes."""
        end = RecordBuilder()
        records.DataEnd(data_section_crc=0).write(end)
        start = size + end.count
        data, offsets = RecordBuilder(), RecordBuilder()
        for opcode, group in self._groups():
            begin = data.count
            for record in group:
                record.write(data)
            length = data.count - begin
            records.SummaryOffset(opcode, start + begin, length).write(offsets)
        offsets_start = start + data.count
        content: bytes = data.end() + offsets.end()
        crc = zlib.crc32(
            _FOOTER.pack(Opcode.FOOTER, _FOOTER_LENGTH, start, offsets_start), zlib.crc32(content)
        )
        footer = RecordBuilder()
        records.Footer(start, offsets_start, crc).write(footer)
        encoded: bytes = end.end() + content + footer.end() + MCAP0_MAGIC
        return encoded

    def _chunks(self) -> Iterator[records.ChunkIndex]:
        """Yield the indices of the chunks, one at a time."""
        yield from map(_decoded, self._encoded)
        if self.last_chunk is not None:
            yield self.last_chunk

    def _groups(self) -> Iterator[tuple[Opcode, Iterable[records.McapRecord]]]:
        """Yield the records of the summary by their opcodes, without empty groups."""
        counts = Counter[int]()
        for one in self._counts:
            counts.update(dict(zip(one[::2], one[1::2], strict=True)))
        statistics = records.Statistics(
            attachment_count=len(self.attachments),
            channel_count=len(self.channels),
            channel_message_counts=dict(counts),
            chunk_count=len(self._counts),
            message_count=counts.total(),
            message_start_time=min((c.message_start_time for c in self._chunks()), default=0),
            message_end_time=max((c.message_end_time for c in self._chunks()), default=0),
            metadata_count=len(self.metadata),
            schema_count=len(self.schemas),
        )
        if self.schemas:
            yield Opcode.SCHEMA, self.schemas.values()
        if self.channels:
            yield Opcode.CHANNEL, self.channels.values()
        yield Opcode.STATISTICS, [statistics]
        if self._counts:
            yield Opcode.CHUNK_INDEX, self._chunks()
        if self.attachments:
            yield Opcode.ATTACHMENT_INDEX, self.attachments
        if self.metadata:
            yield Opcode.METADATA_INDEX, self.metadata


def _encoded(index: records.ChunkIndex) -> bytes:
    builder = RecordBuilder()
    index.write(builder)
    data: bytes = builder.end()
    return data


def _decoded(data: bytes) -> records.ChunkIndex:
    index: records.ChunkIndex = records.ChunkIndex.read(
        ReadDataStream(BytesIO(data[_HEAD_LENGTH:]))
    )
    return index

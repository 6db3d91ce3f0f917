"""The summary section at the end of an MCAP file, by which readers find its content.

Source: MCAP format specification, version 0.
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping

from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

_FOOTER = struct.Struct("<BQQQ")  # opcode, length of the content, offsets of its two sections
_FOOTER_LENGTH = 20  # bytes: both offsets and the checksum


class Summary:
    """What a file has, and where.

    Attributes:
        schemas: Schemas by number.
        channels: Channels by number.
        chunks: Indices of the chunks.
        attachments: Indices of the attachments.
        metadata: Indices of the metadata.
    """

    def __init__(self) -> None:
        self.schemas: dict[int, records.Schema] = {}
        self.channels: dict[int, records.Channel] = {}
        self.chunks: list[records.ChunkIndex] = []
        self.attachments: list[records.AttachmentIndex] = []
        self.metadata: list[records.MetadataIndex] = []
        self._counts: list[Mapping[int, int]] = []

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
        index = records.ChunkIndex(
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
        self.chunks.append(index)
        self._counts.append(counts)
        return index

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
        self.chunks[-1].message_index_offsets[channel] = start
        self.chunks[-1].message_index_length += length

    def drop_partial_index(self) -> bool:
        """Drop the indices of the last chunk's messages unless all channels have one.

        Returns:
            Whether some were missing.
        """
        if not self.chunks or set(self.chunks[-1].message_index_offsets) == set(self._counts[-1]):
            return False
        self.chunks[-1].message_index_offsets.clear()
        self.chunks[-1].message_index_length = 0
        return True

    @property
    def end_time(self) -> float:
        """Time of the last message, s; 0 if there is none."""
        return 1e-9 * max((chunk.message_end_time for chunk in self.chunks), default=0)

    def drop_last_chunk(self) -> int:
        """Drop the last chunk and what follows it; return the chunk's offset, bytes."""
        self._counts.pop()
        size = self.chunks.pop().chunk_start_offset
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

    def _groups(self) -> Iterable[tuple[Opcode, list[records.McapRecord]]]:
        """Return the records of the summary by their opcodes, without empty groups."""
        counts = sum((Counter(one) for one in self._counts), Counter[int]())
        statistics = records.Statistics(
            attachment_count=len(self.attachments),
            channel_count=len(self.channels),
            channel_message_counts=dict(counts),
            chunk_count=len(self.chunks),
            message_count=counts.total(),
            message_start_time=min((c.message_start_time for c in self.chunks), default=0),
            message_end_time=max((c.message_end_time for c in self.chunks), default=0),
            metadata_count=len(self.metadata),
            schema_count=len(self.schemas),
        )
        groups: list[tuple[Opcode, list[records.McapRecord]]] = [
            (Opcode.SCHEMA, [*self.schemas.values()]),
            (Opcode.CHANNEL, [*self.channels.values()]),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, [*self.chunks]),
            (Opcode.ATTACHMENT_INDEX, [*self.attachments]),
            (Opcode.METADATA_INDEX, [*self.metadata]),
        ]
        return [(opcode, group) for opcode, group in groups if group]

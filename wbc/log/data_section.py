"""The data section of an MCAP file, and the summary section that indexes it.

The package `mcap` writes the summary of a file that it has written itself; this module makes one
for a file whose writer was killed. It needs the packages of the extra `log`: import it where it is
used.

Source: MCAP format specification, version 0.
"""

from __future__ import annotations

from collections import Counter
from typing import IO

from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from wbc.log.record_reader import DAMAGE, check_magic, chunk_records


class DataSection:
    """The whole records of an MCAP file's data section.

    Args:
        file: File open for reading.

    Attributes:
        complete: Whether the file has a summary section, too.
        size: Size of the file up to the end of the last whole record, bytes.

    Raises:
        LogError: The file is not an MCAP file.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._schemas: dict[int, records.Schema] = {}
        self._channels: dict[int, records.Channel] = {}
        self._chunks: list[records.ChunkIndex] = []
        self._counts: list[Counter[int]] = []  # messages of each channel in each chunk
        self._attachments: list[records.AttachmentIndex] = []
        self._metadata: list[records.MetadataIndex] = []
        self.size = start = len(MCAP0_MAGIC)
        self.complete = False
        check_magic(file)
        try:
            for record in StreamReader(file, emit_chunks=True, validate_crcs=True).records:
                self._add(record, start, file.tell() - start)
                start = file.tell()
            self.complete = True
        except DAMAGE:
            pass
        if self._chunks and set(self._chunks[-1].message_index_offsets) != set(self._counts[-1]):
            # A chunk has either all of its message indices or none.
            last = self._chunks[-1]
            last.message_index_offsets.clear()
            last.message_index_length = 0
            self.size = last.chunk_start_offset + last.chunk_length

    @property
    def end_time(self) -> float:
        """Time of the last message, s; 0 if there is none."""
        return 1e-9 * max((chunk.message_end_time for chunk in self._chunks), default=0)

    def drop_last_chunk(self) -> bool:
        """Drop the last chunk and what follows it; return False if there is none."""
        if not self._chunks:
            return False
        self._counts.pop()
        self.size = size = self._chunks.pop().chunk_start_offset
        self._attachments = [index for index in self._attachments if index.offset < size]
        self._metadata = [index for index in self._metadata if index.offset < size]
        return True

    def summary(self) -> bytes:
        """Return the bytes that complete a file of `size` bytes."""
        data = RecordBuilder()
        records.DataEnd(data_section_crc=0).write(data)
        start = self.size + data.count
        counts = sum(self._counts, Counter[int]())
        statistics = records.Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=dict(counts),
            chunk_count=len(self._chunks),
            message_count=counts.total(),
            message_start_time=min((c.message_start_time for c in self._chunks), default=0),
            message_end_time=max((c.message_end_time for c in self._chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        for record in (
            *self._schemas.values(),
            *self._channels.values(),
            statistics,
            *self._chunks,
            *self._attachments,
            *self._metadata,
            records.Footer(summary_start=start, summary_offset_start=0, summary_crc=0),
        ):
            record.write(data)
        content: bytes = data.end()
        return content + MCAP0_MAGIC

    def _add(self, record: records.McapRecord, start: int, length: int) -> None:
        """Note a record that begins at offset `start`, and has `length` bytes."""
        if isinstance(record, records.Chunk):
            self._add_chunk(record, start, length)
        elif isinstance(record, records.MessageIndex) and self._chunks:
            self._chunks[-1].message_index_offsets[record.channel_id] = start
            self._chunks[-1].message_index_length += length
        elif isinstance(record, records.Attachment):
            self._attachments.append(
                records.AttachmentIndex(
                    offset=start,
                    length=length,
                    log_time=record.log_time,
                    create_time=record.create_time,
                    data_size=len(record.data),
                    name=record.name,
                    media_type=record.media_type,
                )
            )
        elif isinstance(record, records.Metadata):
            index = records.MetadataIndex(offset=start, length=length, name=record.name)
            self._metadata.append(index)
        elif not isinstance(record, records.Header):
            return  # a part of an unfinished summary
        self.size = start + length

    def _add_chunk(self, chunk: records.Chunk, start: int, length: int) -> None:
        counts = Counter[int]()
        for record in chunk_records(chunk):
            if isinstance(record, records.Message):
                counts[record.channel_id] += 1
            elif isinstance(record, records.Schema):
                self._schemas[record.id] = record
            elif isinstance(record, records.Channel):
                self._channels[record.id] = record
        self._counts.append(counts)
        self._chunks.append(
            records.ChunkIndex(
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
        )

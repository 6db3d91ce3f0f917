"""Completes a log that was interrupted: everything up to its last whole chunk, and an end.

An MCAP file that just stops has lost nothing of what its chunks hold, but most readers want
the summary at its end. It is made of what the chunks say.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections import Counter
from io import BytesIO
from pathlib import Path
from typing import IO, Any

from wbc.log.errors import LogError
from wbc.log.records import (
    ATTACHMENT,
    CHANNEL,
    CHUNK,
    FOOTER,
    HEAD,
    HEADER,
    MAGIC,
    MESSAGE,
    MESSAGE_INDEX,
    METADATA,
    SCHEMA,
    DamagedChunk,
    chunk_data,
    file_records,
    inner_records,
)


def repair(path: Path) -> float:
    """Complete a log in place; a log that is whole stays as it is.

    What follows the last whole chunk is cut off. If the disk has no room for the summary,
    chunks at the end make room for it.

    Returns:
        Time of its last message, s.

    Raises:
        LogError: the file is no MCAP file, or cannot be written.
    """
    try:
        with path.open("rb") as file:
            survey = Survey(file)
        while not survey.complete:
            try:
                _replace_end(path, survey.size, survey.summary())
                break
            except OSError:
                if not survey.chunks:
                    raise
                survey.forget_last_chunk()
        return 1e-9 * survey.end
    except OSError as error:
        raise LogError(f"cannot repair {path}: {error.strerror}") from error


def _replace_end(path: Path, start: int, end: bytes) -> None:
    file = os.open(path, os.O_WRONLY)
    try:
        os.ftruncate(file, start)
        os.lseek(file, start, os.SEEK_SET)
        left = memoryview(end)
        while left:
            left = left[os.write(file, left) :]
        os.fsync(file)
    finally:
        os.close(file)


class Survey:
    """What a log holds, by its records.

    Args:
        file: open for reading.

    Attributes:
        complete: the file has its footer.
        size: bytes up to the end of the last whole chunk.
        chunks: their index records.

    Raises:
        LogError: the file is no MCAP file.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self.complete = False
        self.size = len(MAGIC)
        self.chunks: list[Any] = []
        self._counts: list[Counter[int]] = []
        self._schemas: dict[int, Any] = {}
        self._channels: dict[int, Any] = {}
        self._metadata: list[Any] = []
        self._attachments: list[Any] = []
        for offset, opcode, content in file_records(file):
            end = offset + HEAD.size + len(content)
            if opcode == FOOTER:
                self.complete = file.read(len(MAGIC)) == MAGIC
                break
            if opcode == CHUNK:
                try:
                    self._note_chunk(content, offset)
                except DamagedChunk:
                    break
            elif opcode == MESSAGE_INDEX and self.chunks:
                self._note_index(content, offset)
            elif opcode in (METADATA, ATTACHMENT):
                self._note(opcode, content, offset)
            elif opcode != HEADER:
                continue  # a summary that was not finished
            self.size = end
        self._complete_indices()

    @property
    def end(self) -> int:
        """Time of the last message, ns."""
        return max((chunk.message_end_time for chunk in self.chunks), default=0)

    def forget_last_chunk(self) -> None:
        """Leave the last chunk out, and what follows it."""
        self.size = int(self.chunks.pop().chunk_start_offset)
        self._counts.pop()
        self._metadata = [m for m in self._metadata if m.offset < self.size]
        self._attachments = [a for a in self._attachments if a.offset < self.size]

    def summary(self) -> bytes:
        """Everything from the end of the data to the end of the file."""
        from mcap.data_stream import RecordBuilder
        from mcap.opcode import Opcode
        from mcap.records import DataEnd, Footer, SummaryOffset

        builder = RecordBuilder()
        DataEnd(0).write(builder)
        data_end = builder.end()
        start = self.size + len(data_end)
        offsets = []
        for opcode, group in (
            (Opcode.SCHEMA, list(self._schemas.values())),
            (Opcode.CHANNEL, list(self._channels.values())),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, self.chunks),
            (Opcode.ATTACHMENT_INDEX, self._attachments),
            (Opcode.METADATA_INDEX, self._metadata),
        ):
            before = builder.count
            for record in group:
                record.write(builder)
            if group:
                offsets.append(SummaryOffset(opcode, start + before, builder.count - before))
        offset_start = start + builder.count
        for offset in offsets:
            offset.write(builder)
        summary = builder.end()
        head = struct.pack("<BQQQ", FOOTER, 20, start, offset_start)
        checksum = zlib.crc32(head, zlib.crc32(summary))
        Footer(summary_start=start, summary_offset_start=offset_start, summary_crc=checksum).write(
            builder
        )
        return bytes(data_end + summary + builder.end() + MAGIC)

    def _statistics(self) -> Any:
        from mcap.records import Statistics

        counts: Counter[int] = sum(self._counts, Counter())
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=dict(counts),
            chunk_count=len(self.chunks),
            message_count=sum(counts.values()),
            message_end_time=self.end,
            message_start_time=min((c.message_start_time for c in self.chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )

    def _note(self, opcode: int, content: bytes, offset: int) -> None:
        from mcap.data_stream import ReadDataStream
        from mcap.records import Attachment, AttachmentIndex, Metadata, MetadataIndex

        stream, length = ReadDataStream(BytesIO(content)), HEAD.size + len(content)
        if opcode == METADATA:
            self._metadata.append(MetadataIndex(offset, length, Metadata.read(stream).name))
            return
        a = Attachment.read(stream)
        self._attachments.append(
            AttachmentIndex(
                offset, length, a.log_time, a.create_time, len(a.data), a.name, a.media_type
            )
        )

    def _note_chunk(self, content: bytes, offset: int) -> None:
        from mcap.data_stream import ReadDataStream
        from mcap.records import Channel, Chunk, ChunkIndex, Schema

        data = chunk_data(content)
        counts: Counter[int] = Counter()
        for opcode, start, stop in inner_records(data):
            if opcode == MESSAGE:
                counts[data[start] + 256 * data[start + 1]] += 1
            elif opcode == SCHEMA:
                schema = Schema.read(ReadDataStream(BytesIO(data[start:stop])))
                self._schemas[schema.id] = schema
            elif opcode == CHANNEL:
                channel = Channel.read(ReadDataStream(BytesIO(data[start:stop])))
                self._channels[channel.id] = channel
        chunk = Chunk.read(ReadDataStream(BytesIO(content)))
        self.chunks.append(
            ChunkIndex(
                chunk_length=HEAD.size + len(content),
                chunk_start_offset=offset,
                compression=chunk.compression,
                compressed_size=len(chunk.data),
                message_end_time=chunk.message_end_time,
                message_index_length=0,
                message_index_offsets={},
                message_start_time=chunk.message_start_time,
                uncompressed_size=chunk.uncompressed_size,
            )
        )
        self._counts.append(counts)

    def _note_index(self, content: bytes, offset: int) -> None:
        (channel,) = struct.unpack_from("<H", content)
        self.chunks[-1].message_index_offsets[channel] = offset
        self.chunks[-1].message_index_length += HEAD.size + len(content)

    def _complete_indices(self) -> None:
        """A chunk that lacks some of its indices is read without any."""
        if self.chunks and set(self.chunks[-1].message_index_offsets) != set(self._counts[-1]):
            last = self.chunks[-1]
            last.message_index_offsets.clear()
            last.message_index_length = 0
            self.size = last.chunk_start_offset + last.chunk_length

"""Copies the whole records of an MCAP file, and notes them for its summary.

The module needs the packages of the extra `log`: import it where it is used.
"""

from __future__ import annotations

import contextlib
import zlib
from typing import IO

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, McapRecord, MessageIndex, Schema
from mcap.writer import MCAP0_MAGIC

from wbc.log.data_section import ChunkBlock, DataSection
from wbc.log.record_reader import Block, ChunkIndex, SummarySection, blocks
from wbc.log.summary import Summary


def copy_section(source: IO[bytes], copy: IO[bytes]) -> tuple[DataSection, Summary]:
    """Copy what is whole of a file, with new indices of the messages and a new summary.

    Raises:
        LogError: The source is not an MCAP file.
        OSError: One of them cannot be read or written.
    """
    summary, section = Summary(), DataSection(source)
    _add_descriptions(summary, section.summary.descriptions)
    copy.write(MCAP0_MAGIC + _encoded(_header(source)))
    for _, record in section:
        start = copy.tell()
        if isinstance(record, ChunkBlock):
            _copy_chunk(record, copy, summary)
        elif record is not None:
            copy.write(_encoded(record))
            summary.add(record, start, copy.tell() - start)
    copy.write(summary.encode(copy.tell()))
    return section, summary


def index_section(file: IO[bytes]) -> tuple[DataSection, Summary, int]:
    """Return what is whole of a file, its summary, and where that is to begin, bytes.

    Raises:
        LogError: The file is not an MCAP file.
        OSError: It cannot be read.
    """
    summary, section = Summary(), DataSection(file)
    size = len(MCAP0_MAGIC)
    for block, record in section:
        length, size = block.end - block.start, block.end
        if isinstance(record, ChunkBlock):
            index = ChunkIndex.of(record.content)
            _add_chunk(record.record, index, block.start, length, summary)
        elif record is not None:
            summary.add(record, block.start, length)
        elif summary.last_chunk is not None:
            channel = int.from_bytes(block.data[:2], "little")
            summary.add_message_index(channel, block.start, length)
    last = summary.last_chunk
    if last is not None and summary.drop_partial_index():
        size = last.chunk_start_offset + last.chunk_length
    return section, summary, size


def _header(source: IO[bytes]) -> Header:
    first = next(blocks(source, SummarySection(source)), None)
    if isinstance(first, Block) and first.opcode == Opcode.HEADER:
        with contextlib.suppress(ValueError):
            header = first.parse()
            assert isinstance(header, Header)
            return header
    return Header("ros2", "")


def _add_descriptions(summary: Summary, descriptions: list[Schema | Channel]) -> None:
    for one in descriptions:
        if isinstance(one, Schema):
            summary.schemas[one.id] = one
        else:
            summary.channels[one.id] = one


def _add_chunk(chunk: Chunk, index: ChunkIndex, start: int, length: int, summary: Summary) -> None:
    """Add a chunk to a summary, without the indices of its messages."""
    _add_descriptions(summary, index.descriptions)
    counts = {channel: len(found) for channel, found in index.places.items()}
    summary.add_chunk(chunk, start, length, counts)


def _copy_chunk(chunk: ChunkBlock, copy: IO[bytes], summary: Summary) -> None:
    """Write a chunk and the indices of its messages."""
    index = ChunkIndex.of(chunk.content)
    times = [time for found in index.places.values() for time, _ in found]
    record, start = chunk.record, copy.tell()
    record.message_start_time = min(times, default=0)  # no checksum protects these
    record.message_end_time = max(times, default=0)
    record.uncompressed_crc = zlib.crc32(chunk.content)
    copy.write(_encoded(record))
    _add_chunk(record, index, start, copy.tell() - start, summary)
    for channel, found in index.places.items():
        start = copy.tell()
        copy.write(_encoded(MessageIndex(channel, found)))
        summary.add_message_index(channel, start, copy.tell() - start)


def _encoded(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()
    return data

"""Reads the records of an MCAP file, also of one that was truncated or damaged.

The module needs the packages of the extra `log`: import it where it is used.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from io import BytesIO
from typing import IO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

from wbc.log.errors import LogError

#: What the package `mcap` raises where a file is truncated or damaged.
DAMAGE = (McapError, ZstdError, RuntimeError, struct.error, ValueError)  # RuntimeError: lz4
_RECORD = struct.Struct("<BQ")  # opcode, length of the content
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence number, log time, publish time
_DESCRIPTIONS: dict[int, type[Schema | Channel]] = {
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
}


class _WithoutIndices(StreamReader):
    """A reader that skips the indices of messages, which take as long as the messages."""

    def _read_record(self, opcode: int, length: int) -> McapRecord | None:
        return None if opcode == Opcode.MESSAGE_INDEX else super()._read_record(opcode, length)


class RecordReader:
    """Iterates over the records of an MCAP file up to the first one that is truncated or damaged.

    Args:
        file: File open for reading.
        emit_chunks: Whether chunks are returned whole, unchecked, in place of their records.

    Attributes:
        complete: Whether the whole file has been read, up to the footer at its end.

    Raises:
        LogError: The file is not an MCAP file.
    """

    def __init__(self, file: IO[bytes], emit_chunks: bool = False) -> None:
        if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            raise LogError(f"{file.name} is not an MCAP file")
        file.seek(0)
        self.complete = False
        self._emit_chunks = emit_chunks
        reader = StreamReader if emit_chunks else _WithoutIndices
        self._reader = reader(file, emit_chunks=True, validate_crcs=True)

    def __iter__(self) -> Iterator[McapRecord]:
        """Yield the records in the order of the file."""
        try:
            for record in self._reader.records:
                if isinstance(record, Chunk) and not self._emit_chunks:
                    yield from chunk_records(record)
                else:
                    yield record
            self.complete = True
        except DAMAGE:
            return


def chunk_records(chunk: Chunk) -> Iterator[Schema | Channel | Message]:
    """Yield the records of a chunk, in a fraction of the time that the package `mcap` takes.

    Raises:
        Exception: The chunk is damaged: one of `DAMAGE`.
    """
    stream, size = get_chunk_data_stream(chunk, validate_crc=True)
    data = stream.read(size)
    end = 0
    while end < size:
        opcode, length = _RECORD.unpack_from(data, end)
        start = end + _RECORD.size
        end = start + length
        if opcode == Opcode.MESSAGE:
            channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(data, start)
            content = data[start + _MESSAGE.size : end]
            yield Message(channel, log_time, content, publish_time, sequence)
        elif opcode in _DESCRIPTIONS:
            yield _DESCRIPTIONS[opcode].read(ReadDataStream(BytesIO(data[start:end])))

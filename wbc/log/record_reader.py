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


def check_magic(file: IO[bytes]) -> None:
    """Check that a file, open at its beginning, is an MCAP file.

    Raises:
        LogError: It is not.
    """
    if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise LogError(f"{file.name} is not an MCAP file")
    file.seek(0)


def read_records(file: IO[bytes]) -> Iterator[McapRecord]:
    """Yield the records of an MCAP file and of its chunks, except the indices of messages.

    Raises:
        Exception: The next record is truncated or damaged: one of `DAMAGE`.
        LogError: The file is not an MCAP file.
    """
    check_magic(file)
    for record in _WithoutIndices(file, emit_chunks=True, validate_crcs=True).records:
        if isinstance(record, Chunk):
            yield from chunk_records(record)
        else:
            yield record


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

"""Reads the whole records of an MCAP file; works for truncated files, too.

Source: MCAP format specification 0.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from wbc.log.errors import LogError
from wbc.log.format.records import HEAD, MAGIC

_CHUNK = struct.Struct("<QQQI")  # start and end time, uncompressed size, checksum
_LENGTH = struct.Struct("<I")
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log and publish time


class DamagedChunk(LogError):
    """A chunk's bytes are corrupted."""


def file_records(file: IO[bytes]) -> Iterator[tuple[int, int, bytes]]:
    """Yield (offset, opcode, content) of each record up to the first incomplete or invalid one.

    Raises:
        LogError: The file is not an MCAP file.
    """
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        raise LogError(f"{Path(file.name)} is not an MCAP file")
    while True:
        offset = file.tell()
        head = file.read(HEAD.size)
        if len(head) < HEAD.size:
            return
        opcode, length = HEAD.unpack(head)
        if opcode == 0 or length > size - offset - HEAD.size:
            return
        yield offset, opcode, file.read(length)


def chunk_data(content: bytes) -> bytes:
    """Return the decompressed records of a chunk.

    Raises:
        DamagedChunk: The records do not decompress, or their checksum does not match.
        LogError: The compression is not supported.
    """
    _, _, size, checksum = _CHUNK.unpack_from(content)
    at = _CHUNK.size
    (length,) = struct.unpack_from("<I", content, at)
    compression = content[at + 4 : at + 4 + length].decode()
    packed = content[at + 4 + length + 8 :]
    if compression == "":
        data = packed
    elif compression == "zstd":
        import zstandard

        try:
            data = zstandard.decompress(packed, size)
        except zstandard.ZstdError as error:
            raise DamagedChunk(f"a chunk cannot be decompressed: {error}") from error
    else:
        raise LogError(f"a chunk is compressed with '{compression}'; only zstd is supported")
    if checksum and zlib.crc32(data) != checksum:
        raise DamagedChunk("the checksum of a chunk does not match its content")
    return data


def inner_records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield (opcode, start, stop) of the content of each record inside a chunk."""
    at, end, unpack, head = 0, len(data), HEAD.unpack_from, HEAD.size
    while at < end:
        opcode, length = unpack(data, at)
        at += head
        yield opcode, at, at + length
        at += length


def string_at(data: bytes, at: int) -> tuple[str, int]:
    """Return the string at an offset, and the offset of its end."""
    (size,) = _LENGTH.unpack_from(data, at)
    return data[at + 4 : at + 4 + size].decode("utf-8", "replace"), at + 4 + size


def message_at(data: bytes, start: int, stop: int) -> tuple[int, int, bytes]:
    """Return (channel, log time in ns, data) of a message record inside a chunk."""
    channel, _, time, _ = _MESSAGE.unpack_from(data, start)
    return channel, time, data[start + _MESSAGE.size : stop]

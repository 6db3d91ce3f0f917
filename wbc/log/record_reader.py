"""Reads the records of an MCAP file, also of one that was truncated or damaged.

What fails its checksum or cannot be parsed is skipped: reading goes on with the next record, or,
where the length of a record is damaged, with the next chunk.

The module needs the packages of the extra `log`: import it where it is used.

Source: MCAP format specification, version 0.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections import defaultdict
from collections.abc import Container, Iterator, Mapping
from io import BytesIO
from types import MappingProxyType
from typing import IO, Any, NamedTuple

from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.stream_reader import get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

from wbc.log.errors import LogError

#: What the package `mcap` raises where a record is damaged.
_DAMAGE = (
    McapError, ZstdError, RuntimeError, struct.error, ValueError, OverflowError, MemoryError,
)  # fmt: skip  # RuntimeError: lz4
_HEAD = struct.Struct("<BQ")  # opcode, length of the content
_CHANNEL_AND_TIME = struct.Struct("<H4xQ")  # of a message, with its sequence number between them
_MESSAGE_SIZE = _CHANNEL_AND_TIME.size + 8  # bytes before its data: the publish time follows
_INDEXED_CHUNK = struct.Struct("<QQQQI")  # times, offset, length, length of the next field
_LENGTH = struct.Struct("<Q")
_FOOTER_SIZE = _HEAD.size + 20 + len(MCAP0_MAGIC)  # bytes, with the magic bytes at the end
_TYPES: dict[int, Any] = {
    Opcode.HEADER: records.Header,
    Opcode.SCHEMA: records.Schema,
    Opcode.CHANNEL: records.Channel,
    Opcode.CHUNK: records.Chunk,
    Opcode.ATTACHMENT: records.Attachment,
    Opcode.METADATA: records.Metadata,
    Opcode.STATISTICS: records.Statistics,
    Opcode.CHUNK_INDEX: records.ChunkIndex,
    Opcode.ATTACHMENT_INDEX: records.AttachmentIndex,
    Opcode.METADATA_INDEX: records.MetadataIndex,
    Opcode.FOOTER: records.Footer,
}
_PRIVATE = 0x80  # opcodes from here on belong to the programs that write files
_COMPRESSED = (b"\x04\0\0\0zstd", b"\x03\0\0\0lz4")  # compression, as it lies in a chunk
_BEFORE_COMPRESSION = _HEAD.size + 28  # bytes of a chunk before the name of its compression
_SEARCHED = 1 << 20  # bytes at a time


class Block(NamedTuple):
    """A record as it lies in the file.

    Attributes:
        opcode: Kind of the record.
        start: Offset of the record, bytes.
        data: Its content.
    """

    opcode: int
    start: int
    data: bytes

    @property
    def end(self) -> int:
        """Offset of what follows, bytes."""
        return self.start + _HEAD.size + len(self.data)

    def parse(self) -> Any:
        """Return the record, an instance of a class of `mcap.records`.

        Raises:
            ValueError: It is damaged.
        """
        try:
            if self.opcode == Opcode.ATTACHMENT:
                (crc,) = struct.unpack("<I", self.data[-4:])
                if crc not in (0, zlib.crc32(self.data[:-4])):
                    raise ValueError("the checksum of an attachment is wrong")
            return _TYPES[self.opcode].read(ReadDataStream(BytesIO(self.data)))
        except _DAMAGE as error:
            raise ValueError(str(error)) from error


class Damage(NamedTuple):
    """A part of a file that cannot be read.

    Attributes:
        start: Its offset, bytes.
        end: Offset of the next record that can be read, or the size of the file.
    """

    start: int
    end: int


class IndexedChunk(NamedTuple):
    """A chunk as the summary section describes it.

    Attributes:
        start: Offset of its record, bytes.
        end: Offset of what follows it and the indices of its messages, bytes.
        first: Time of its first message, ns.
        last: Time of its last message, ns.
    """

    start: int
    end: int
    first: int
    last: int

    @staticmethod
    def of(data: bytes) -> IndexedChunk:
        """Return what the content of a chunk's index says.

        Raises:
            ValueError: It is damaged.
        """
        try:
            first, last, start, length, places = _INDEXED_CHUNK.unpack_from(data)
            (indices,) = _LENGTH.unpack_from(data, _INDEXED_CHUNK.size + places)
        except struct.error as error:
            raise ValueError(str(error)) from error
        return IndexedChunk(start, start + length + indices, first, last)


class SummarySection:
    """What the summary section states that data may lack.

    Attributes:
        descriptions: Schemas and channels.
        offsets: Offsets of chunks, attachments and metadata, ascending.
        chunks: Index of each chunk by its offset.
        end_time: Time of the last message, ns; NaN if the file has no summary.
        found: Whether the file has its end.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self.descriptions: list[records.Schema | records.Channel] = []
        self.offsets: list[int] = []
        self.chunks: dict[int, IndexedChunk] = {}
        self.end_time = math.nan
        self.found = False
        for block in _summary_blocks(file):
            try:
                if block.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                    self.descriptions.append(block.parse())
                elif block.opcode == Opcode.CHUNK_INDEX:
                    chunk = IndexedChunk.of(block.data)
                    self.offsets.append(chunk.start)
                    self.chunks[chunk.start] = chunk
                elif block.opcode in (Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX):
                    self.offsets.append(block.parse().offset)
                elif block.opcode == Opcode.STATISTICS:
                    self.end_time = block.parse().message_end_time
                elif block.opcode == Opcode.FOOTER:
                    self.found = True
            except ValueError:
                continue
        self.offsets.sort()


def check_magic(file: IO[bytes]) -> None:
    """Check that a file, open at its beginning, is an MCAP file.

    Raises:
        LogError: It is not.
    """
    if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise LogError(f"{file.name} is not an MCAP file")


def blocks(
    file: IO[bytes], summary: SummarySection, skipped: Mapping[int, int] = MappingProxyType({})
) -> Iterator[Block | Damage]:
    """Yield the records of the data section in order, each as a block.

    Args:
        file: The file, which is an MCAP file.
        summary: Its summary section.
        skipped: Offset of each part that is not read, with the offset of what follows it.
    """
    size = file.seek(0, 2)
    start = len(MCAP0_MAGIC)
    while start < size:
        if start in skipped:
            start = skipped[start]
            continue
        block = _block(file, start, size)
        if block is None:
            following = _next_record(file, summary, start + 1, size)
            yield Damage(start, following)
            start = following
            continue
        yield block
        start = block.end
        if block.opcode == Opcode.DATA_END:
            return


def chunk_content(chunk: records.Chunk) -> bytes:
    """Return the records of a chunk.

    Raises:
        ValueError: The chunk is damaged.
    """
    try:
        stream, size = get_chunk_data_stream(chunk, validate_crc=True)
        content: bytes = stream.read(size)
    except _DAMAGE as error:
        raise ValueError(str(error)) from error
    return content


class TimedMessage(NamedTuple):
    """A serialized message.

    Attributes:
        channel: Number of its channel.
        log_time: Log time, ns.
        data: Serialized message.
    """

    channel: int
    log_time: int
    data: bytes


def chunk_records(
    content: bytes, channels: Container[int]
) -> Iterator[records.Schema | records.Channel | TimedMessage]:
    """Yield schemas and channels of a chunk, and the messages of some channels.

    It takes a fraction of the time that the package `mcap` takes.

    Args:
        content: The chunk's records.
        channels: Numbers of the channels, which may become more when a channel was yielded.
    """
    for opcode, start, end in _places(content):
        if opcode == Opcode.MESSAGE:
            channel, log_time = _CHANNEL_AND_TIME.unpack_from(content, start)
            if channel in channels:
                yield TimedMessage(channel, log_time, content[start + _MESSAGE_SIZE : end])
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            yield Block(opcode, 0, content[start:end]).parse()


class ChunkIndex(NamedTuple):
    """What a chunk has.

    Attributes:
        places: Log times, ns, and offsets of the messages of each channel.
        descriptions: Schemas and channels.
    """

    places: dict[int, list[tuple[int, int]]]
    descriptions: list[records.Schema | records.Channel]

    @staticmethod
    def of(content: bytes) -> ChunkIndex:
        """Return the index of a chunk with a content."""
        places: defaultdict[int, list[tuple[int, int]]] = defaultdict(list)
        descriptions = []
        for opcode, start, end in _places(content):
            if opcode == Opcode.MESSAGE:
                channel, time = _CHANNEL_AND_TIME.unpack_from(content, start)
                places[channel].append((time, start - _HEAD.size))
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                descriptions.append(Block(opcode, 0, content[start:end]).parse())
        return ChunkIndex(dict(places), descriptions)


def _places(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, start and end of the content of each record of a chunk."""
    end, size = 0, len(content)
    while end < size:
        opcode, length = _HEAD.unpack_from(content, end)
        start = end + _HEAD.size
        end = start + length
        yield opcode, start, end


def block_at(file: IO[bytes], start: int) -> Block | None:
    """Return the record that begins at an offset, bytes; None if none does, or it is not whole."""
    return _block(file, start, file.seek(0, 2))


def _block(file: IO[bytes], start: int, size: int) -> Block | None:
    """Return the record that begins at an offset; None if none does, or its end is missing."""
    file.seek(start)
    head = file.read(_HEAD.size)
    if len(head) < _HEAD.size:
        return None
    opcode, length = _HEAD.unpack(head)
    known = Opcode.HEADER <= opcode <= Opcode.DATA_END or opcode >= _PRIVATE
    if not known or length > size - start - _HEAD.size:
        return None
    return Block(opcode, start, file.read(length))


def _next_record(file: IO[bytes], summary: SummarySection, start: int, size: int) -> int:
    """Return the offset of what can be read next; the file's size if there is nothing."""
    for offset in summary.offsets:
        if offset >= start:
            return offset
    if summary.found:
        return size
    while start < size:
        file.seek(start)
        data = file.read(_SEARCHED + _BEFORE_COMPRESSION + 8)
        for name in _COMPRESSED:
            place = data.find(name, _BEFORE_COMPRESSION)
            while place >= 0:
                chunk = start + place - _BEFORE_COMPRESSION
                block = _block(file, chunk, size)
                if block is not None and block.opcode == Opcode.CHUNK:
                    return chunk
                place = data.find(name, place + 1)
        start += _SEARCHED
    return size


def _summary_blocks(file: IO[bytes]) -> Iterator[Block]:
    size = file.seek(0, 2)
    footer = _block(file, max(size - _FOOTER_SIZE, 0), size)
    if footer is None or footer.opcode != Opcode.FOOTER:
        return
    try:
        start = footer.parse().summary_start
    except ValueError:
        return
    while start and start < footer.start:
        block = _block(file, start, footer.start)
        if block is None:
            break
        yield block
        start = block.end
    yield footer

"""The records of an MCAP file as bytes.

Source: MCAP format specification, version 0. Every record is its opcode, the length of its
content and the content; strings, maps and arrays begin with their size in bytes.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA, METADATA_INDEX = range(9, 14)
SUMMARY_OFFSET, DATA_END = 14, 15
HEAD = struct.Struct("<BQ")
#: A message up to its data: opcode, length, channel, number, time of log and of publication.
MESSAGE_HEAD = struct.Struct("<BQHIQQ")
MESSAGE_HEAD_CONTENT = MESSAGE_HEAD.size - HEAD.size


def record(opcode: int, content: bytes) -> bytes:
    """A record."""
    return HEAD.pack(opcode, len(content)) + content


def text(value: str) -> bytes:
    """A string."""
    data = value.encode("utf-8", "replace")
    return struct.pack("<I", len(data)) + data


def table(values: Mapping[str, str]) -> bytes:
    """A map of strings."""
    data = b"".join(text(key) + text(value) for key, value in values.items())
    return struct.pack("<I", len(data)) + data


def numbers(values: Mapping[int, int]) -> bytes:
    """A map of channels to 64-bit numbers."""
    data = b"".join(struct.pack("<HQ", key, value) for key, value in values.items())
    return struct.pack("<I", len(data)) + data


def header(profile: str, library: str) -> bytes:
    """The first record."""
    return record(HEADER, text(profile) + text(library))


def schema(number: int, name: str, encoding: str, data: bytes) -> bytes:
    """Content of a schema record."""
    head = struct.pack("<H", number) + text(name) + text(encoding)
    return head + struct.pack("<I", len(data)) + data


def channel(number: int, schema_number: int, topic: str, metadata: Mapping[str, str]) -> bytes:
    """Content of a channel record, of CDR messages."""
    return struct.pack("<HH", number, schema_number) + text(topic) + text("cdr") + table(metadata)


def chunk(start: int, end: int, size: int, checksum: int, compression: str, packed: bytes) -> bytes:
    """A chunk of records.

    Args:
        start: time of its first message, ns.
        end: time of its last message, ns.
        size: of its records, bytes.
        checksum: CRC-32 of its records.
        compression: "zstd", or nothing.
        packed: the records, compressed.
    """
    head = struct.pack("<QQQI", start, end, size, checksum) + text(compression)
    return record(CHUNK, head + struct.pack("<Q", len(packed)) + packed)


def message_index(channel_number: int, places: list[int]) -> bytes:
    """Where a channel's messages are in the chunk before.

    Args:
        channel_number: of the channel.
        places: time (ns) and offset of each message in turn.
    """
    data = struct.pack(f"<HI{len(places)}Q", channel_number, 8 * len(places), *places)
    return record(MESSAGE_INDEX, data)


def metadata_record(name: str, values: Mapping[str, str]) -> bytes:
    """Names and values."""
    return record(METADATA, text(name) + table(values))


def attachment(name: str, media_type: str, data: bytes) -> bytes:
    """A file in the file."""
    content = struct.pack("<QQ", 0, 0) + text(name) + text(media_type)
    content += struct.pack("<Q", len(data)) + data
    return record(ATTACHMENT, content + struct.pack("<I", zlib.crc32(content)))

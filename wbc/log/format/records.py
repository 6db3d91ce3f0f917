"""Encodes the records of an MCAP file.

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
#: Head of a message record: opcode, length, channel, sequence number, log and publish time.
MESSAGE_HEAD = struct.Struct("<BQHIQQ")
MESSAGE_HEAD_CONTENT = MESSAGE_HEAD.size - HEAD.size


def record(opcode: int, content: bytes) -> bytes:
    """Return a record: opcode, length and content."""
    return HEAD.pack(opcode, len(content)) + content


def text(value: str) -> bytes:
    """Return an encoded string."""
    data = value.encode("utf-8", "replace")
    return struct.pack("<I", len(data)) + data


def table(values: Mapping[str, str]) -> bytes:
    """Return an encoded map of strings."""
    data = b"".join(text(key) + text(value) for key, value in values.items())
    return struct.pack("<I", len(data)) + data


def numbers(values: Mapping[int, int]) -> bytes:
    """Return an encoded map from channels to 64-bit numbers."""
    data = b"".join(struct.pack("<HQ", key, value) for key, value in values.items())
    return struct.pack("<I", len(data)) + data


def header(profile: str, library: str) -> bytes:
    """Return the header, which is the first record."""
    return record(HEADER, text(profile) + text(library))


def schema(number: int, name: str, encoding: str, data: bytes) -> bytes:
    """Return the content of a schema record."""
    head = struct.pack("<H", number) + text(name) + text(encoding)
    return head + struct.pack("<I", len(data)) + data


def channel(number: int, schema_number: int, topic: str, metadata: Mapping[str, str]) -> bytes:
    """Return the content of a channel record for CDR messages."""
    return struct.pack("<HH", number, schema_number) + text(topic) + text("cdr") + table(metadata)


def chunk(start: int, end: int, size: int, checksum: int, compression: str, packed: bytes) -> bytes:
    """Return a chunk record.

    Args:
        start: Time of the first message, ns.
        end: Time of the last message, ns.
        size: Uncompressed size of the records, bytes.
        checksum: CRC-32 of the uncompressed records.
        compression: "zstd", or empty for no compression.
        packed: The compressed records.
    """
    head = struct.pack("<QQQI", start, end, size, checksum) + text(compression)
    return record(CHUNK, head + struct.pack("<Q", len(packed)) + packed)


def message_index(channel_number: int, places: list[int]) -> bytes:
    """Return the index of a channel's messages in the preceding chunk.

    Args:
        channel_number: Channel id.
        places: Time (ns) and offset (bytes) of each message, alternating.
    """
    data = struct.pack(f"<HI{len(places)}Q", channel_number, 8 * len(places), *places)
    return record(MESSAGE_INDEX, data)


def metadata_record(name: str, values: Mapping[str, str]) -> bytes:
    """Return a metadata record of names and values."""
    return record(METADATA, text(name) + table(values))


def attachment(name: str, media_type: str, data: bytes) -> bytes:
    """Return an attachment record, which embeds a file."""
    content = struct.pack("<QQ", 0, 0) + text(name) + text(media_type)
    content += struct.pack("<Q", len(data)) + data
    return record(ATTACHMENT, content + struct.pack("<I", zlib.crc32(content)))

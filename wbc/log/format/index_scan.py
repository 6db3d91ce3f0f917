"""Scans an MCAP file record by record; works for truncated files, too."""

from __future__ import annotations

import struct
from collections import Counter
from typing import IO

from wbc.log.format.contents import ChunkInfo, Contents, RecordLocation
from wbc.log.format.reading import (
    DamagedChunk,
    chunk_data,
    file_records,
    inner_records,
    string_at,
)
from wbc.log.format.records import (
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
    text,
)


class IndexScan:
    """The contents of an MCAP file, found by scanning its records.

    Args:
        file: File open for reading.

    Attributes:
        contents: Contents up to the last whole chunk.
        size: Size of the file up to the end of that chunk, bytes.
        complete: Whether the file ends with a summary and footer.

    Raises:
        LogError: The file is not an MCAP file.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self.contents = contents = Contents()
        self.size = len(MAGIC)
        self.complete = False
        for offset, opcode, content in file_records(file):
            length = HEAD.size + len(content)
            if opcode == FOOTER:
                self.complete = file.read(len(MAGIC)) == MAGIC
                break
            if opcode == CHUNK:
                try:
                    self._note_chunk(offset, content)
                except DamagedChunk:
                    break
            elif opcode == MESSAGE_INDEX and contents.chunks:
                self._note_index(offset, content)
            elif opcode == METADATA:
                name, _ = string_at(content, 0)
                contents.metadata.append(RecordLocation(offset, length, text(name)))
            elif opcode == ATTACHMENT:
                contents.attachments.append(
                    RecordLocation(offset, length, attachment_index(content))
                )
            elif opcode != HEADER:
                continue  # belongs to an unfinished summary
            self.size = offset + length
        if contents.chunks and set(contents.chunks[-1].indices) != set(contents.chunks[-1].counts):
            contents.chunks[-1].drop_indices()
            self.size = contents.chunks[-1].after

    def _note_chunk(self, offset: int, content: bytes) -> None:
        data = chunk_data(content)
        counts: Counter[int] = Counter()
        for opcode, start, stop in inner_records(data):
            if opcode == MESSAGE:
                counts[data[start] + 256 * data[start + 1]] += 1
            elif opcode in (SCHEMA, CHANNEL):
                (number,) = struct.unpack_from("<H", data, start)
                kind = self.contents.schemas if opcode == SCHEMA else self.contents.channels
                kind[number] = data[start:stop]
        begin, end, size = struct.unpack_from("<QQQ", content)
        compression, at = string_at(content, 28)
        self.contents.chunks.append(
            ChunkInfo(
                offset=offset,
                length=HEAD.size + len(content),
                start=begin,
                end=end,
                compression=compression,
                packed=len(content) - at - 8,
                size=size,
                counts=counts,
            )
        )

    def _note_index(self, offset: int, content: bytes) -> None:
        (channel,) = struct.unpack_from("<H", content)
        chunk = self.contents.chunks[-1]
        chunk.indices[channel] = offset
        chunk.indices_length += HEAD.size + len(content)


def attachment_index(content: bytes) -> bytes:
    """Return the fields of an attachment record that its index repeats."""
    times = content[:16]
    name, at = string_at(content, 16)
    media_type, at = string_at(content, at)
    return times + content[at : at + 8] + text(name) + text(media_type)

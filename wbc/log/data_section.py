"""The data section of an MCAP file whose writer was killed, and the end that completes it.

The module needs the packages of the extra `log`: import it where it is used.

Source: MCAP format specification, version 0.
"""

from __future__ import annotations

from collections import Counter
from typing import IO

from mcap import records
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from wbc.log.record_reader import DAMAGE, check_magic, chunk_records
from wbc.log.summary import Summary


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
        self._summary = summary = Summary()
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
        if (
            summary.chunks
            and set(summary.chunks[-1].message_index_offsets) != summary.last_channels
        ):
            # A chunk has either all of its message indices or none.
            last = summary.chunks[-1]
            last.message_index_offsets.clear()
            last.message_index_length = 0
            self.size = last.chunk_start_offset + last.chunk_length

    @property
    def end_time(self) -> float:
        """Time of the last message, s; 0 if there is none."""
        return 1e-9 * max((chunk.message_end_time for chunk in self._summary.chunks), default=0)

    def drop_last_chunk(self) -> bool:
        """Drop the last chunk and what follows it; return False if there is none."""
        if not self._summary.chunks:
            return False
        self.size = self._summary.drop_last_chunk()
        return True

    def summary(self) -> bytes:
        """Return the bytes that complete a file of `size` bytes."""
        return self._summary.encode(self.size)

    def _add(self, record: records.McapRecord, start: int, length: int) -> None:
        """Note a record that begins at offset `start`, and has `length` bytes."""
        summary = self._summary
        if isinstance(record, records.Chunk):
            summary.add_chunk(record, start, length, self._count(record))
        elif isinstance(record, records.MessageIndex) and summary.chunks:
            summary.chunks[-1].message_index_offsets[record.channel_id] = start
            summary.chunks[-1].message_index_length += length
        elif isinstance(record, records.Attachment):
            summary.add_attachment(record, start, length)
        elif isinstance(record, records.Metadata):
            summary.add_metadata(record, start, length)
        elif not isinstance(record, records.Header):
            return  # a part of an unfinished summary
        self.size = start + length

    def _count(self, chunk: records.Chunk) -> Counter[int]:
        """Note the schemas and channels of a chunk; return how many messages each channel has."""
        counts = Counter[int]()
        for record in chunk_records(chunk):
            if isinstance(record, records.Message):
                counts[record.channel_id] += 1
            elif isinstance(record, records.Schema):
                self._summary.schemas[record.id] = record
            elif isinstance(record, records.Channel):
                self._summary.channels[record.id] = record
        return counts

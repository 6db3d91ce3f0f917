"""Reads the records of an MCAP file, also of one that was truncated or damaged.

The module needs the packages of the extra `log`: import it where it is used.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import IO

from mcap.exceptions import McapError
from mcap.records import McapRecord
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

from wbc.log.errors import LogError

#: What the package `mcap` raises where a file is truncated or damaged.
DAMAGE = (McapError, ZstdError, RuntimeError, struct.error, ValueError)  # RuntimeError: lz4


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
        self._reader = StreamReader(file, emit_chunks=emit_chunks, validate_crcs=True)

    def __iter__(self) -> Iterator[McapRecord]:
        """Yield the records in the order of the file."""
        try:
            yield from self._reader.records
            self.complete = True
        except DAMAGE:
            return

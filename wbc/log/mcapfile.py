"""Writes a log as an MCAP file. Only the log writer's process uses this.

Of 70 MB per minute (Talos at 500 Hz, `benchmarks/log.py`) 23 are `/joint_states`, whose numbers are
stored exactly, 22 are sensors, targets and accelerations in single precision, and 8 are message
indices. These hardly compress: the highest levels of zstd save 2 % and take ten times as long.

Source: MCAP format specification, version 0; profile and channel metadata as rosbag2 writes
them (`rosbag2_storage_mcap`).
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import zstandard
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.writer import MCAP0_MAGIC

import wbc
from wbc.log.message_chunk import MessageChunk
from wbc.log.metadata import Metadata
from wbc.log.summary import Summary
from wbc.messages import Message, message_type
from wbc.topics import LatchedTopic, MessageBlock, MessageTopic, TickBatch

_LEVEL = 3  # of zstandard
_QOS = (
    "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n"
    "  deadline:\n    sec: 2147483647\n    nsec: 4294967295\n"
    "  lifespan:\n    sec: 2147483647\n    nsec: 4294967295\n"
    "  liveliness: 1\n"
    "  liveliness_lease_duration:\n    sec: 2147483647\n    nsec: 4294967295\n"
    "  avoid_ros_namespace_conventions: false\n"
)


class McapFile:
    """An MCAP file of ROS 2 messages that is written chunk by chunk.

    Args:
        path: Path of the file. An existing file is overwritten.

    Raises:
        OSError: The file cannot be opened or written.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = path.open("wb")
        self._size = 0
        self._compressor = zstandard.ZstdCompressor(level=_LEVEL)
        self._chunk = MessageChunk()
        self._summary = Summary()
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._write(MCAP0_MAGIC)
        self._write_record(records.Header("ros2", f"wbc {wbc.__version__}"))
        self.commit()

    def add(self, metadata: Metadata) -> None:
        """Write metadata and attachments."""
        for name, table in metadata.tables.items():
            values = {key: _utf8(value) for key, value in table.items()}
            one = records.Metadata(name=name, metadata=values)
            self._summary.add_metadata(one, *self._write_record(one))
        for name, content in metadata.files.items():
            kind = "application/json" if name.endswith(".json") else "text/plain"
            attachment = records.Attachment(0, 0, name, kind, content.encode())
            self._summary.add_attachment(attachment, *self._write_record(attachment))

    def write(self, batch: TickBatch, topics: Sequence[MessageTopic]) -> None:
        """Append the messages of a batch to the current chunk, in order of time."""
        blocks = [
            (self._channel(topic.name, topic.type_name, isinstance(topic, LatchedTopic)), block)
            for topic in topics
            for block in topic.messages(batch)
        ]
        self._chunk.add_messages(batch.stamps, blocks)

    def write_message(self, topic: str, stamp: int, message: Message) -> None:
        """Append one message to the current chunk.

        Args:
            topic: Name of its topic.
            stamp: Its time, ns.
            message: The message.
        """
        block = MessageBlock.of(0, message.encode())
        channel = self._channel(topic, type(message).type_name, latched=False)
        self._chunk.add_messages(np.array([stamp], np.int64), [(channel, block)])

    def commit(self) -> None:
        """End the chunk and write it to the disk.

        Raises:
            OSError: Writing failed; the file may end with a part of the chunk.
        """
        if self._chunk.counts:
            chunk, self._chunk = self._chunk, MessageChunk()
            self._write_chunk(chunk)
        self._file.flush()
        getattr(os, "fdatasync", os.fsync)(self._file.fileno())

    def finish(self) -> None:
        """Write the summary section and the footer, and close the file.

        Raises:
            OSError: Writing failed.
        """
        self.commit()
        self._write(self._summary.encode(self._size))
        self._file.close()

    def close(self) -> None:
        """Close the file as it is.

        Raises:
            OSError: What was not written yet cannot be written.
        """
        self._file.close()

    def _write_chunk(self, chunk: MessageChunk) -> None:
        """Write a chunk and the indices of its messages."""
        content = chunk.records()
        first, last = chunk.span()
        record = records.Chunk(
            compression="zstd",
            data=self._compressor.compress(content),
            message_start_time=first,
            message_end_time=last,
            uncompressed_crc=zlib.crc32(content),
            uncompressed_size=len(content),
        )
        index = self._summary.add_chunk(record, *self._write_record(record), chunk.counts)
        for channel, data in chunk.message_indices().items():
            index.message_index_offsets[channel], length = self._write(data)
            index.message_index_length += length

    def _write_record(self, record: records.McapRecord) -> tuple[int, int]:
        builder = RecordBuilder()
        record.write(builder)
        return self._write(builder.end())

    def _write(self, data: bytes) -> tuple[int, int]:
        """Write bytes; return their offset and their number."""
        start = self._size
        self._file.write(data)
        self._size += len(data)
        return start, len(data)

    def _channel(self, name: str, type_name: str, latched: bool) -> int:
        """Return the number of a topic's channel, which is registered at its first message."""
        if name not in self._channels:
            durability, depth = (1, 1) if latched else (2, 10)
            channel = records.Channel(
                id=len(self._channels) + 1,
                topic="/" + name.lstrip("/"),
                message_encoding="cdr",
                schema_id=self._schema(type_name),
                metadata={
                    "offered_qos_profiles": _QOS.format(durability=durability, depth=depth),
                    "topic_type_hash": message_type(type_name).type_hash(),
                },
            )
            self._channels[name] = channel.id
            self._summary.channels[channel.id] = channel
            self._chunk.add_record(channel)
        return self._channels[name]

    def _schema(self, type_name: str) -> int:
        if type_name not in self._schemas:
            schema = records.Schema(
                id=len(self._schemas) + 1,
                name=type_name,
                encoding="ros2msg",
                data=message_type(type_name).schema().encode(),
            )
            self._schemas[type_name] = schema.id
            self._summary.schemas[schema.id] = schema
            self._chunk.add_record(schema)
        return self._schemas[type_name]


def _utf8(text: str) -> str:
    """Replace what UTF-8 cannot encode, such as parts of a command line in another encoding."""
    return text.encode("utf-8", "replace").decode()

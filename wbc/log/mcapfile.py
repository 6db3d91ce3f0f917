"""Writes a log as an MCAP file. Only the log writer's process uses this.

The package `mcap` writes the same messages into a file of the same size, in 4.5 µs of CPU per
message instead of 1.9, 3.6 % of a core instead of 1.5 (`benchmarks/log.py`). CPU time is not the
main reason to avoid it: it ends chunks by size only, and it cannot complete a file in place after
its writer was killed or the disk was full (`wbc.log.recovery`). Recovery needs the record encoding
in any case, and with that a writer takes only the 100 lines below.

Of 70 MB per minute (Talos at 500 Hz, same source) 23 are `/joint_states`, whose numbers are
stored exactly, 22 are sensors, targets and accelerations in single precision, and 8 are message
indices. These hardly compress: the highest levels of zstd save 2 % and take ten times as long.

Source: MCAP format specification, version 0; profile and channel metadata as rosbag2 writes
them (`rosbag2_storage_mcap`).
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from pathlib import Path

import zstandard

import wbc
from wbc.log.format.contents import ChunkInfo, Contents, RecordLocation
from wbc.log.format.index_scan import attachment_index
from wbc.log.format.records import (
    CHANNEL,
    HEAD,
    MAGIC,
    MESSAGE,
    MESSAGE_HEAD,
    MESSAGE_HEAD_CONTENT,
    SCHEMA,
    attachment,
    channel,
    chunk,
    header,
    message_index,
    metadata_record,
    record,
    schema,
    text,
)
from wbc.log.metadata import Metadata
from wbc.log.output import Output
from wbc.messages import schema_text, type_hash
from wbc.topics import MessageTopic, TickBatch

_LEVEL = 3  # zstandard compression level
_QOS = (
    "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n"
    "  deadline:\n    sec: 2147483647\n    nsec: 4294967295\n"
    "  lifespan:\n    sec: 2147483647\n    nsec: 4294967295\n"
    "  liveliness: 1\n"
    "  liveliness_lease_duration:\n    sec: 2147483647\n    nsec: 4294967295\n"
    "  avoid_ros_namespace_conventions: false\n"
)


class McapFile:
    """An MCAP file that is written chunk by chunk, each followed by its message indices.

    Args:
        path: Path of the file.

    Raises:
        OSError: The file cannot be opened or written.
    """

    def __init__(self, path: Path) -> None:
        self._output = Output(path)
        self._contents = Contents()
        self._compressor = zstandard.ZstdCompressor(level=_LEVEL)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._sequence: dict[int, int] = {}
        self._begin()
        self._output.write(MAGIC + header("ros2", f"wbc {wbc.__version__}"))
        self._output.commit()

    def _begin(self) -> None:
        """Begin a chunk."""
        self._parts: list[bytes] = []
        self._size = 0
        self._places: dict[int, list[int]] = {}

    def add(self, metadata: Metadata) -> None:
        """Write metadata and attachments."""
        for name, values in metadata.tables.items():
            data = metadata_record(name, values)
            self._contents.metadata.append(
                RecordLocation(self._output.tell(), len(data), text(name))
            )
            self._output.write(data)
        for name, content in metadata.files.items():
            kind = "application/json" if name.endswith(".json") else "text/plain"
            data = attachment(name, kind, content.encode())
            place = RecordLocation(
                self._output.tell(), len(data), attachment_index(data[HEAD.size :])
            )
            self._contents.attachments.append(place)
            self._output.write(data)

    def write(self, batch: TickBatch, topics: Sequence[MessageTopic]) -> None:
        """Append the messages of a batch to the current chunk, in order of time."""
        ticks: list[list[tuple[int, bytes]]] = [[] for _ in range(len(batch))]
        for topic in topics:
            found = topic.messages(batch)
            if found:
                number = self._channel(topic)
                for tick, data in found:
                    ticks[tick].append((number, data))
        parts, places, sequence, at = self._parts, self._places, self._sequence, self._size
        head = MESSAGE_HEAD.pack
        for stamp, messages in zip(batch.stamps.tolist(), ticks, strict=True):
            for number, data in messages:
                sequence[number] = count = sequence[number] + 1
                length = MESSAGE_HEAD_CONTENT + len(data)
                parts += (head(MESSAGE, length, number, count, stamp, stamp), data)
                places[number] += (stamp, at)
                at += HEAD.size + length
        self._size = at

    def commit(self) -> None:
        """End the chunk and write it to the disk.

        Raises:
            OSError: Writing failed; the file ends with the previous chunk.
        """
        places = {number: found for number, found in self._places.items() if found}
        if places:
            self._write_chunk(places)
            self._begin()
            self._places = {number: [] for number in self._sequence}
        self._output.commit()

    def _write_chunk(self, places: dict[int, list[int]]) -> None:
        records = b"".join(self._parts)
        packed = self._compressor.compress(records)
        start = min(found[0] for found in places.values())
        end = max(found[-2] for found in places.values())
        data = chunk(start, end, len(records), zlib.crc32(records), "zstd", packed)
        info = ChunkInfo(
            offset=self._output.tell(),
            length=len(data),
            start=start,
            end=end,
            compression="zstd",
            packed=len(packed),
            size=len(records),
        )
        self._output.write(data)
        for number, found in places.items():
            index = message_index(number, found)
            info.indices[number] = self._output.tell()
            info.indices_length += len(index)
            info.counts[number] = len(found) // 2
            self._output.write(index)
        self._contents.chunks.append(info)

    def finish(self) -> None:
        """Write the summary section and the footer.

        Raises:
            OSError: Writing failed; the file ends with the last chunk.
        """
        self._output.write(self._contents.ending(self._output.tell()))
        self._output.commit()

    def close(self) -> None:
        """Close the file."""
        self._output.close()

    def _channel(self, topic: MessageTopic) -> int:
        number = self._channels.get(topic.name)
        if number is None:
            number = self._channels[topic.name] = len(self._channels) + 1
            name = "/" + topic.name.lstrip("/")
            self._sequence[number] = 0
            self._places[number] = []
            durability, depth = (1, 1) if topic.latched else (2, 10)
            metadata = {
                "offered_qos_profiles": _QOS.format(durability=durability, depth=depth),
                "topic_type_hash": type_hash(topic.type_name),
            }
            content = channel(number, self._schema(topic.type_name), name, metadata)
            self._contents.channels[number] = content
            self._put(record(CHANNEL, content))
        return number

    def _schema(self, type_name: str) -> int:
        number = self._schemas.get(type_name)
        if number is None:
            number = self._schemas[type_name] = len(self._schemas) + 1
            content = schema(number, type_name, "ros2msg", schema_text(type_name).encode())
            self._contents.schemas[number] = content
            self._put(record(SCHEMA, content))
        return number

    def _put(self, data: bytes) -> None:
        """Append a record other than a message to the chunk."""
        self._parts.append(data)
        self._size += len(data)

"""Writes a log as an MCAP file. Only the log writer's process uses this.

Of 70 MB per minute (Talos at 500 Hz, `benchmarks/log.py`) 23 are `/joint_states`, whose numbers are
stored exactly, 22 are sensors, targets and accelerations in single precision, and 8 are message
indices. These hardly compress: the highest levels of zstd save 2 % and take ten times as long.

Source: MCAP format specification, version 0; profile and channel metadata as rosbag2 writes
them (`rosbag2_storage_mcap`).
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from operator import itemgetter
from pathlib import Path

from mcap.writer import Writer

import wbc
from wbc.log.metadata import Metadata
from wbc.messages import message_type
from wbc.topics import LatchedTopic, MessageTopic, TickBatch

_CHUNK_SIZE = 1 << 24  # bytes; chunks end by `commit`, and by their size only after a long delay
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
        self._writer = Writer(self._file, chunk_size=_CHUNK_SIZE)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._writer.start("ros2", f"wbc {wbc.__version__}")
        self.commit()

    def add(self, metadata: Metadata) -> None:
        """Write metadata and attachments."""
        for name, table in metadata.tables.items():
            self._writer.add_metadata(name, {key: _utf8(value) for key, value in table.items()})
        for name, content in metadata.files.items():
            kind = "application/json" if name.endswith(".json") else "text/plain"
            self._writer.add_attachment(0, 0, name, kind, content.encode())

    def write(self, batch: TickBatch, topics: Sequence[MessageTopic]) -> None:
        """Append the messages of a batch to the current chunk, in order of time."""
        stamps = batch.stamps.tolist()
        messages = [
            (tick, self._channel(topic), data)
            for topic in topics
            for tick, data in topic.messages(batch)
        ]
        for tick, channel, data in sorted(messages, key=itemgetter(0)):
            self._writer.add_message(channel, stamps[tick], data, stamps[tick])

    def commit(self) -> None:
        """End the chunk and write it to the disk.

        Raises:
            OSError: Writing failed; the file may end with a part of the chunk.
        """
        self._writer.flush()
        getattr(os, "fdatasync", os.fsync)(self._file.fileno())

    def finish(self) -> None:
        """Write the summary section and the footer, and close the file.

        Raises:
            OSError: Writing failed.
        """
        self._writer.finish()
        self._file.close()

    def close(self) -> None:
        """Close the file as it is.

        Raises:
            OSError: What was not written yet cannot be written.
        """
        self._file.close()

    def _channel(self, topic: MessageTopic) -> int:
        """Return the number of a topic's channel, which is registered at its first message."""
        if topic.name not in self._channels:
            durability, depth = (1, 1) if isinstance(topic, LatchedTopic) else (2, 10)
            metadata = {
                "offered_qos_profiles": _QOS.format(durability=durability, depth=depth),
                "topic_type_hash": message_type(topic.type_name).type_hash(),
            }
            self._channels[topic.name] = self._writer.register_channel(
                "/" + topic.name.lstrip("/"), "cdr", self._schema(topic.type_name), metadata
            )
        return self._channels[topic.name]

    def _schema(self, type_name: str) -> int:
        if type_name not in self._schemas:
            text = message_type(type_name).schema().encode()
            self._schemas[type_name] = self._writer.register_schema(type_name, "ros2msg", text)
        return self._schemas[type_name]


def _utf8(text: str) -> str:
    """Replace what UTF-8 cannot encode, such as parts of a command line in another encoding."""
    return text.encode("utf-8", "replace").decode()
